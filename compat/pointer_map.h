// What belongs to addresses, side by side in one array: what is looked for is mostly there at the
// first look, which costs one cache miss, where lists of nodes cost several, one after the other.
// Knuth, The Art of Computer Programming, volume 3, section 6.4, algorithms L and R.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace dacrt::compat {

/// Values stay in no place: Add and Remove may move them.
template <class Value>
class PointerMap {
 public:
  /// Null if nothing belongs to `key`, which may be any address, or null.
  Value* Find(const void* key) {
    if (places_.empty() || !key) return nullptr;
    Place& place = places_[PlaceOf(key)];
    return place.key ? &place.value : nullptr;
  }
  const Value* Find(const void* key) const { return const_cast<PointerMap*>(this)->Find(key); }

  /// `key` is not null. Replaces what belongs to it. Throws std::bad_alloc; nothing has changed
  /// then.
  void Add(const void* key, Value value) {
    if (2 * (count_ + 1) > places_.size()) Grow();
    Place& place = places_[PlaceOf(key)];
    count_ += !place.key;
    place = {key, std::move(value)};
  }

  /// Nothing belongs to `key` any more.
  void Remove(const void* key) {
    if (!Find(key)) return;
    --count_;
    // Those behind it come nearer to where they are looked for first.
    std::size_t gap = PlaceOf(key);
    for (std::size_t next = After(gap); places_[next].key; next = After(next)) {
      if (Distance(FirstPlaceOf(places_[next].key), next) < Distance(gap, next)) continue;
      places_[gap] = std::move(places_[next]);
      gap = next;
    }
    places_[gap] = {};
  }

 private:
  struct Place {
    const void* key = nullptr;
    Value value;
  };

  static constexpr std::size_t kFewest = 64;

  /// By the golden ratio, which spreads addresses at any distance from each other.
  std::size_t FirstPlaceOf(const void* key) const {
    constexpr uint64_t kFactor = 0x9E3779B97F4A7C15u;
    return (reinterpret_cast<std::uintptr_t>(key) * kFactor >> 32) & (places_.size() - 1);
  }
  std::size_t After(std::size_t place) const { return (place + 1) & (places_.size() - 1); }
  /// The end of the array is followed by its beginning.
  std::size_t Distance(std::size_t from, std::size_t to) const {
    return (to - from) & (places_.size() - 1);
  }

  /// Where a key is, or would be: at most half of the places are taken.
  std::size_t PlaceOf(const void* key) const {
    std::size_t place = FirstPlaceOf(key);
    while (places_[place].key && places_[place].key != key) place = After(place);
    return place;
  }

  void Grow() {
    std::vector<Place> old(places_.empty() ? kFewest : 2 * places_.size());
    old.swap(places_);
    for (Place& place : old) {
      if (place.key) places_[PlaceOf(place.key)] = std::move(place);
    }
  }

  std::vector<Place> places_;  ///< a power of two
  std::size_t count_ = 0;
};

}  // namespace dacrt::compat
