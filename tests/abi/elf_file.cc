#include "elf_file.h"

#include <elf.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <span>
#include <stdexcept>
#include <vector>

namespace dacrt::tests {
namespace {

/// The `Entry`s that section `section` holds.
template <class Entry>
std::span<const Entry> Entries(const std::vector<char>& file, const Elf64_Shdr& section) {
  if (section.sh_offset + section.sh_size > file.size()) throw std::runtime_error("truncated ELF");
  return {reinterpret_cast<const Entry*>(file.data() + section.sh_offset),
          section.sh_size / sizeof(Entry)};
}

}  // namespace

ElfFile ReadElfFile(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  const std::vector<char> file{std::istreambuf_iterator<char>(stream), {}};
  if (file.size() < sizeof(Elf64_Ehdr) || std::memcmp(file.data(), ELFMAG, SELFMAG) != 0 ||
      file[EI_CLASS] != ELFCLASS64) {
    throw std::runtime_error(path + " is no 64-bit ELF file");
  }
  const auto& header = *reinterpret_cast<const Elf64_Ehdr*>(file.data());
  const std::span sections(reinterpret_cast<const Elf64_Shdr*>(file.data() + header.e_shoff),
                           header.e_shnum);
  ElfFile result;
  for (const Elf64_Shdr& section : sections) {
    const auto name = [&](std::size_t offset) {
      return file.data() + sections[section.sh_link].sh_offset + offset;
    };
    if (section.sh_type == SHT_GNU_verdef) result.has_versions = true;
    if (section.sh_type == SHT_DYNAMIC) {
      for (const auto& entry : Entries<Elf64_Dyn>(file, section)) {
        if (entry.d_tag == DT_SONAME) result.soname = name(entry.d_un.d_val);
      }
    }
    if (section.sh_type == SHT_DYNSYM) {
      for (const auto& symbol : Entries<Elf64_Sym>(file, section)) {
        if (symbol.st_shndx != SHN_UNDEF) result.exports.insert(name(symbol.st_name));
      }
    }
  }
  return result;
}

}  // namespace dacrt::tests
