// SPDX-License-Identifier: MIT
#include "block_cholesky.h"

#include <algorithm>

namespace phymul {

void BlockCholesky::analyse(const BlockMatrix& matrix) {
  const Index rows = matrix.rows();
  std::vector<Eigen::Triplet<double>> triplets;
  for (Index row = 0; row < rows; ++row) {
    for (const Index column : matrix.columns_of(row)) triplets.emplace_back(row, column, 1.0);
  }
  Eigen::SparseMatrix<double> blocks(rows, rows);
  blocks.setFromTriplets(triplets.begin(), triplets.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(blocks, order);
  row_at_.assign(order.indices().begin(), order.indices().end());
  std::vector<Index> place_of(row_at_.size());
  for (Index place = 0; place < rows; ++place) place_of[row_at_[place]] = place;

  triplets.clear();
  entries_.clear();
  first_entry_.assign(1, 0);
  std::vector<Index> above;
  for (Index place = 0; place < rows; ++place) {
    above.clear();
    for (const Index other : matrix.columns_of(row_at_[place])) {
      if (place_of[other] <= place) above.push_back(place_of[other]);
    }
    std::ranges::sort(above);
    for (const Index at : above) {
      entries_.push_back(matrix.entry(row_at_[at], row_at_[place]));
      for (int b = 0; b < 3; ++b) {
        for (int a = 0; a < (at == place ? b + 1 : 3); ++a) triplets.emplace_back(3 * at + a, 3 * place + b, 0.0);
      }
    }
    first_entry_.push_back(entries_.size());
  }
  upper_.resize(3 * rows, 3 * rows);
  upper_.setFromTriplets(triplets.begin(), triplets.end());
  factors_.analyzePattern(upper_);
}

void BlockCholesky::factorise(const BlockMatrix& matrix) {
  double* value = upper_.valuePtr();
  for (std::size_t place = 0; place + 1 < first_entry_.size(); ++place) {
    const std::size_t last = first_entry_[place + 1] - 1;
    for (int b = 0; b < 3; ++b) {
      for (std::size_t e = first_entry_[place]; e <= last; ++e) {
        const auto column = matrix.at(entries_[e]).col(b);
        value = std::copy_n(column.data(), e == last ? b + 1 : 3, value);
      }
    }
  }
  factors_.factorize(upper_);
}

void BlockCholesky::solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  ordered_.resize(b.size());
  for (std::size_t place = 0; place < row_at_.size(); ++place) {
    ordered_.segment<3>(3 * static_cast<Eigen::Index>(place)) = b.segment<3>(3 * row_at_[place]);
  }
  ordered_ = factors_.solve(ordered_);
  x.resize(b.size());
  for (std::size_t place = 0; place < row_at_.size(); ++place) {
    x.segment<3>(3 * row_at_[place]) = ordered_.segment<3>(3 * static_cast<Eigen::Index>(place));
  }
}

}  // namespace phymul
