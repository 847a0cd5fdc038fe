#include "problems/measurement_rows.h"

#include <cstring>
#include <stdexcept>

namespace sagitta {
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

void MeasurementRows::AddCells(std::string_view text) {
  const std::size_t first = store_->text.size();
  store_->text.append(text);
  store_->text.push_back(kSeparator);
  const char* const begin = store_->text.data();
  const char* const end = begin + store_->text.size();
  for (const char* at = begin + first; at != end; ++at) {
    at = static_cast<const char*>(std::memchr(at, kSeparator, static_cast<std::size_t>(end - at)));
    store_->ends.push_back(static_cast<std::uint32_t>(at - begin));
  }
}

void MeasurementRows::Reserve(std::size_t rows, std::size_t cells, std::size_t bytes) {
  Store* const own = Own();
  own->rows.reserve(rows);
  own->ends.reserve(cells);
  own->text.reserve(bytes);
}

}  // namespace sagitta
