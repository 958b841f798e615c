// A table of the pairs to be checked.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tandem {

/// A bit for each pair of a row and a column: the pairs that are to be checked. Of a robot's links with one another (as
/// many rows as columns; only row i, column j with i < j is read), or of its links with a scene's bodies (columns: body
/// indices; those beyond the last column are checked).
class PairTable {
 public:
  PairTable() = default;  ///< no rows: no pair
  PairTable(std::size_t rows, std::size_t columns, bool checked)
      : rows_(rows),
        columns_(columns),
        words_((columns + 63) / 64),
        bits_(rows * words_, checked ? ~std::uint64_t{0} : 0) {}

  std::size_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }
  /// Both within range, which is not checked: `row` < rows(), `column` < columns().
  bool checked(std::size_t row, std::size_t column) const {
    return (bits_[row * words_ + column / 64] >> column % 64 & 1u) != 0;
  }
  /// Sets a pair; ranges as above.
  void set(std::size_t row, std::size_t column, bool checked) {
    std::uint64_t& word = bits_[row * words_ + column / 64];
    const std::uint64_t bit = std::uint64_t{1} << column % 64;
    word = checked ? word | bit : word & ~bit;
  }

 private:
  std::size_t rows_ = 0, columns_ = 0, words_ = 0;
  std::vector<std::uint64_t> bits_;
};

}  // namespace tandem
