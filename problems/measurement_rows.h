// The cells of a file's rows: one text, and where in it each cell ends. A hundred thousand rows of twenty columns need
// 20 MB instead of 70, and copies of the rows share them until one is changed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace sagitta {

// Rows in the order of their file.
class MeasurementRows {
  struct Store;

 public:
  // A row's cells, in the memory of the rows: they stay while no row is added or changed.
  class Cells {
   public:
    std::size_t size() const { return count_; }
    std::string_view operator[](std::size_t column) const;
    // The same; throws std::out_of_range where there is no such column.
    std::string_view at(std::size_t column) const;
    bool operator==(const Cells& other) const;

   private:
    friend class MeasurementRows;
    Cells(const Store& store, std::size_t first, std::size_t count) : store_(&store), first_(first), count_(count) {}

    const Store* store_;
    std::size_t first_, count_;  // of all cells
  };

  // What a row holds; itself it holds nothing.
  struct Row {
    int line = 0;  // in the file, from 1
    Cells cells;
  };

  // A row that is put together.
  struct NewRow {
    int line = 0;  // in the file, from 1
    std::vector<std::string> cells;
  };

  class Iterator {
   public:
    Row operator*() const { return (*rows_)[row_]; }
    Iterator& operator++() {
      ++row_;
      return *this;
    }
    bool operator!=(const Iterator& other) const { return row_ != other.row_; }

   private:
    friend class MeasurementRows;
    Iterator(const MeasurementRows* rows, std::size_t row) : rows_(rows), row_(row) {}

    const MeasurementRows* rows_;
    std::size_t row_;
  };

  MeasurementRows() = default;
  MeasurementRows(std::initializer_list<NewRow> rows);

  std::size_t size() const { return store_ == nullptr ? 0 : store_->rows.size(); }
  bool empty() const { return size() == 0; }
  Row operator[](std::size_t row) const;
  // The same; throws std::out_of_range where there is no such row.
  Row at(std::size_t row) const;
  Row front() const { return (*this)[0]; }
  int LineOf(std::size_t row) const { return store_->rows[row].line; }
  Iterator begin() const { return {this, 0}; }
  Iterator end() const { return {this, size()}; }

  void push_back(const NewRow& row);
  // A row of other rows, as it is.
  void Append(const Row& row);
  void SetCell(std::size_t row, std::size_t column, std::string_view text);
  void clear() { store_.reset(); }

  // A row's beginning; its cells follow one by one.
  void BeginRow(int line);
  void AddCell(std::string_view text) {
    store_->text.append(text);
    store_->ends.push_back(static_cast<std::uint32_t>(store_->text.size()));
    store_->text.push_back(kSeparator);
  }
  // All cells of a row, as they are: with one separator between two.
  void AddCells(std::string_view text);
  static constexpr char kSeparator = ',';
  // Room for what will come.
  void Reserve(std::size_t rows, std::size_t cells, std::size_t bytes);

 private:
  struct Begin {
    int line = 0;
    std::uint32_t first = 0;  // of its cells
  };
  // limits::kFileBytes is far below what 32 bits count.
  struct Store {
    std::string text;  // cell by cell, a separator behind each
    std::vector<std::uint32_t> ends;
    std::vector<Begin> rows;
  };

  Store* Own();  // not shared

  std::shared_ptr<Store> store_;
};

inline std::string_view MeasurementRows::Cells::operator[](std::size_t column) const {
  const std::size_t cell = first_ + column;
  const std::size_t begin = cell == 0 ? 0 : store_->ends[cell - 1] + 1;
  return {store_->text.data() + begin, store_->ends[cell] - begin};
}

inline MeasurementRows::Row MeasurementRows::operator[](std::size_t row) const {
  const std::size_t first = store_->rows[row].first;
  const std::size_t end = row + 1 < store_->rows.size() ? store_->rows[row + 1].first : store_->ends.size();
  return {store_->rows[row].line, {*store_, first, end - first}};
}

}  // namespace sagitta
