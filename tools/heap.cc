#include "tools/heap.h"

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>

namespace sagitta {
namespace {

// Matrices come and go by the thousand. The C library would give the large ones back at once, and the kernel clear
// their pages anew for the next: a tenth of the time of a diagnosis (BENCHMARKS.md).
void KeepFreedMemory() {
  // Matrices of up to 32 MB, the most that glibc allows, come from a heap of which 256 MB are kept.
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
}

// Long tables touch each of their pages once, and half of that is the kernel's work for a page of 4 kB. Where it has
// them it shall give pages of 2 MB: asked for over the room of a heap that begins with the heap's first growth. What
// is not touched of that room is not there; where it cannot be had, pages are as they were.
void AskForLargePages() {
  constexpr int kRoom = 240 << 20;  // bytes: 10^5 rows need 170 MB; less than what is trimmed
  constexpr std::uintptr_t kPage = 2 << 20;
  mallopt(M_TOP_PAD, kRoom);
  void* const first = std::malloc(8 << 20);  // more than the libraries leave of the first growth
  mallopt(M_TOP_PAD, 128 << 10);             // as it was
  const std::uintptr_t begin = (reinterpret_cast<std::uintptr_t>(first) / kPage + 1) * kPage;
  const std::uintptr_t end = reinterpret_cast<std::uintptr_t>(sbrk(0));
  if (begin < end) madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
  std::free(first);
}

}  // namespace

void PrepareHeap() {
  KeepFreedMemory();
  AskForLargePages();
}

}  // namespace sagitta
