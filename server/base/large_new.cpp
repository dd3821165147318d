// operator new for large arrays, of whatever class: they lie in huge pages if the kernel gives some (transparent_hugepage is `always` or `madvise`). A mesh of
// 5 million tetrahedra is touched page by page otherwise, which on a virtual machine took two thirds of the time of a step of a series.
//
// Everything else is as the library has it: what is small goes to malloc, and all is freed by free. Linked into every program of ours by whoever uses new.
#ifndef ISOSTRATA_SANITIZED  // sanitizers bring their own

#include <cstdlib>
#include <new>

#include "base/kept_blocks.h"

static constexpr std::size_t kLarge = 2 * isostrata::kHugePage;

void* operator new(std::size_t size) {
  for (;;) {
    if (void* const at = size >= kLarge ? isostrata::in_huge_pages(size) : std::malloc(size > 0 ? size : 1)) return at;
    const std::new_handler handler = std::get_new_handler();
    if (!handler) throw std::bad_alloc();
    handler();
  }
}

void operator delete(void* at) noexcept { std::free(at); }
void operator delete(void* at, std::size_t) noexcept { std::free(at); }

#endif
