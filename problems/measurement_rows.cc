#include "problems/measurement_rows.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace sagitta {
namespace {

constexpr std::size_t kBytesAtOnce = 8;

// Of eight bytes the highest bit of those that are separators; the first byte is the lowest.
std::uint64_t SeparatorsIn(const char* bytes) {
  constexpr std::uint64_t kOnes = 0x0101010101010101ULL, kLow = 0x7F * kOnes;
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < kBytesAtOnce; ++i) {  // one load, where the lowest byte comes first
    word |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[i])) << (8 * i);
  }
  word ^= kOnes * static_cast<unsigned char>(MeasurementRows::kSeparator);
  // A byte is zero where neither its lower bits nor its highest are set; the sum carries over into no other byte.
  return ~(((word & kLow) + kLow) | word | kLow);
}

// Which byte the lowest mark is in; any, where there is none.
std::uint32_t LowestByte(std::uint64_t marks) {
  return static_cast<std::uint32_t>(__builtin_ctzll(marks | (std::uint64_t{1} << 63))) / 8;
}

}  // namespace

std::string_view MeasurementRows::Cells::at(std::size_t column) const {
  if (column >= count_) throw std::out_of_range("the row has no such column");
  return (*this)[column];
}

bool MeasurementRows::Cells::operator==(const Cells& other) const {
  bool equal = count_ == other.count_;
  for (std::size_t c = 0; equal && c < count_; ++c) equal = (*this)[c] == other[c];
  return equal;
}

MeasurementRows::MeasurementRows(std::initializer_list<NewRow> rows) {
  for (const NewRow& row : rows) push_back(row);
}

MeasurementRows::Row MeasurementRows::at(std::size_t row) const {
  if (row >= size()) throw std::out_of_range("there is no such row");
  return (*this)[row];
}

MeasurementRows::Store* MeasurementRows::Own() {
  if (store_ == nullptr) {
    store_ = std::make_shared<Store>();
  } else if (store_.use_count() > 1) {
    store_ = std::make_shared<Store>(*store_);
  }
  return store_.get();
}

void MeasurementRows::push_back(const NewRow& row) {
  BeginRow(row.line);
  for (const std::string& cell : row.cells) AddCell(cell);
}

void MeasurementRows::Append(const Row& row) {
  std::vector<std::string> cells;  // they may be this one's
  for (std::size_t c = 0; c < row.cells.size(); ++c) cells.emplace_back(row.cells[c]);
  push_back({row.line, cells});
}

void MeasurementRows::SetCell(std::size_t row, std::size_t column, std::string_view text) {
  const MeasurementRows before = *this;
  clear();
  Reserve(before.size(), before.store_->ends.size(), before.store_->text.size() + text.size());
  for (std::size_t r = 0; r < before.size(); ++r) {
    const Row own = before[r];
    BeginRow(own.line);
    for (std::size_t c = 0; c < own.cells.size(); ++c) AddCell(r == row && c == column ? text : own.cells[c]);
  }
}

void MeasurementRows::BeginRow(int line) {
  Store* const own = Own();
  own->rows.push_back({line, static_cast<std::uint32_t>(own->ends.size())});
}

// Eight bytes at a time: most hold one separator or two, and these are written without a jump for each.
void MeasurementRows::AddCells(std::string_view text) {
  constexpr std::size_t kMost = 1024;  // bytes whose ends are appended together
  const std::size_t first = store_->text.size();
  store_->text.append(text);
  store_->text.push_back(kSeparator);
  const std::size_t size = text.size() + 1;
  std::uint32_t ends[kMost + 2];
  for (std::size_t done = 0; done < size; done += kMost) {
    const char* const bytes = store_->text.data() + first + done;
    const std::size_t own = std::min(kMost, size - done);
    std::size_t count = 0;
    const auto take = [&](const char* from, std::size_t at) {
      std::uint64_t marks = SeparatorsIn(from);
      const auto take_lowest = [&] {
        ends[count] = static_cast<std::uint32_t>(first + done + at) + LowestByte(marks);
        count += marks != 0 ? 1 : 0;
        marks &= marks - 1;
      };
      take_lowest();
      take_lowest();
      while (marks != 0) take_lowest();
    };
    std::size_t at = 0;
    for (; at + kBytesAtOnce <= own; at += kBytesAtOnce) take(bytes + at, at);
    if (at < own) {
      char rest[kBytesAtOnce] = {};
      std::memcpy(rest, bytes + at, own - at);
      take(rest, at);
    }
    store_->ends.insert(store_->ends.end(), ends, ends + count);
  }
}

void MeasurementRows::Reserve(std::size_t rows, std::size_t cells, std::size_t bytes) {
  Store* const own = Own();
  own->rows.reserve(rows);
  own->ends.reserve(cells);
  own->text.reserve(bytes);
}

}  // namespace sagitta
