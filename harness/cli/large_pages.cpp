// Large arrays of this program lie on pages of 2 MiB, as far as the system has them: each page that is
// touched first costs a call of the system, and a volume's arrays have half a million pages of 4 KiB. A
// virtual machine pays most for them.
#if defined(__linux__)
#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <new>

/// Replaces the allocation of all containers. What it returns is given back by free(), as the standard
/// library does.
// NOLINTBEGIN(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory,misc-new-delete-overloads): it is
// what they ask for
void* operator new(std::size_t bytes) {
  constexpr std::size_t large_page = std::size_t{1} << 21;
  const std::size_t on_large_pages =
      bytes / large_page * large_page; // the rest would take a page that it does not fill
  const bool is_large = bytes >= large_page;
  for (;;) {
    void* const at = is_large
                         ? std::aligned_alloc(large_page, (bytes + large_page - 1) / large_page * large_page)
                         : std::malloc(bytes > 0 ? bytes : 1);
    if (at != nullptr) {
      if (is_large) {
        (void)madvise(at, on_large_pages, MADV_HUGEPAGE); // advice only: where it fails pages are small
      }
      return at;
    }
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) {
      throw std::bad_alloc();
    }
    handler();
  }
}
// NOLINTEND(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory,misc-new-delete-overloads)
#endif
