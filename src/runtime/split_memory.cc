#include "runtime/split_memory.h"

#include <new>
#include <utility>

namespace dacrt {

SubsetScratch* SplitMemory::Take() {
  if (!scratch_ && pool_ && !loan_) {
    try {
      loan_.emplace(*pool_).Reserve(WorkspaceShape());
      scratch_ = &loan_->operator*().scratch().subset;
    } catch (const std::bad_alloc&) {
      loan_.reset();
    }
  }
  return std::exchange(scratch_, nullptr);
}

}  // namespace dacrt
