// Numbers for the words of a column: what rows are put together by.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string_view>
#include <vector>

#include "models/random_bits.h"

namespace sagitta {

// Places of things by their hashes, in one piece of memory: a place is in the first slot from its hash on that was
// free.
class PlacesByHash {
 public:
  // The place that was put there by this hash for which is_it(place) is true; `next` is put there where there is none.
  template <typename IsIt>
  int FindOrPut(size_t hash, int next, const IsIt& is_it) {
    if (2 * (count_ + 1) > slots_.size()) Grow(std::max(kFewest, 2 * slots_.size()));
    for (size_t i = hash >> shift_;; i = i + 1 == slots_.size() ? 0 : i + 1) {
      Slot& slot = slots_[i];
      if (slot.place < 0) {
        slot = {hash, next};
        ++count_;
        return next;
      }
      if (slot.hash == hash && is_it(slot.place)) return slot.place;
    }
  }
  void Reserve(size_t places) {
    size_t size = kFewest;
    while (size < 2 * (places + 1)) size *= 2;
    if (size > slots_.size()) Grow(size);
  }

 private:
  static constexpr size_t kFewest = 64;
  struct Slot {
    size_t hash = 0;
    int place = -1;
  };

  void Grow(size_t size) {
    std::vector<Slot> before(size);
    before.swap(slots_);
    shift_ = 64;
    for (size_t left = size; left > 1; left /= 2) --shift_;
    for (const Slot& slot : before) {
      if (slot.place < 0) continue;
      size_t i = slot.hash >> shift_;
      while (slots_[i].place >= 0) i = i + 1 == size ? 0 : i + 1;
      slots_[i] = slot;
    }
  }

  std::vector<Slot> slots_;  // a power of two of them: the hash's highest bits say where
  size_t count_ = 0;
  int shift_ = 64;
};

// Fibonacci hashing (Knuth 6.4): the highest bits depend on all of them.
constexpr std::uint64_t kSpread = kGoldenBits;

// The hash of one more number: by its upper bits; equal numbers have equal ones, 0 and -0 among them.
inline std::uint64_t HashWith(double number, std::uint64_t hash) {
  const double own = number + 0.0;  // -0 + 0 = 0
  std::uint64_t bits = 0;
  std::memcpy(&bits, &own, sizeof(bits));
  return (hash ^ hash >> 32 ^ bits) * kSpread;
}

// Ids by number, in order of appearance. Most rows say what the row before said, or what followed that when it was
// said last.
class IdsByText {
 public:
  int IndexOf(std::string_view word) {
    if (!words_.empty() && words_[last_].text == word) return static_cast<int>(last_);
    size_t index = words_.empty() ? 0 : words_[last_].followed_by;
    if (words_.empty() || words_[index].text != word) {
      const auto next = static_cast<int>(words_.size());
      index =
          static_cast<size_t>(places_.FindOrPut(std::hash<std::string_view>()(word) * kSpread, next, [&](int place) {
            return words_[static_cast<size_t>(place)].text == word;
          }));
      if (index == words_.size()) words_.push_back({word, index});
      words_[last_].followed_by = index;
    }
    last_ = index;
    return static_cast<int>(index);
  }

  void Reserve(size_t words) {
    words_.reserve(words);
    places_.Reserve(words);
  }

 private:
  struct Word {
    std::string_view text;  // in the memory of the rows
    size_t followed_by;
  };
  std::vector<Word> words_;
  PlacesByHash places_;
  size_t last_ = 0;
};

}  // namespace sagitta
