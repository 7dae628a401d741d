#include "query/embeddings.h"

#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <sstream>

namespace hgg {

Result<Embeddings> Embeddings::parse(const std::string& text, const std::string& source_name) {
  Embeddings table;
  std::size_t size = 0;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.empty() || line.front() == '#') {
      continue;
    }
    const std::size_t tab = line.find('\t');
    std::vector<float> vector;
    std::istringstream numbers(tab == std::string::npos ? std::string{} : line.substr(tab + 1));
    for (float v = 0; numbers >> v;) {
      vector.push_back(v);
    }
    const double norm = std::sqrt(std::inner_product(vector.begin(), vector.end(), vector.begin(), 0.0));
    if (vector.empty() || !numbers.eof() || !std::isfinite(norm) || norm == 0 || (size != 0 && vector.size() != size)) {
      return Result<Embeddings>::fail(fmt::format(
          "{}:{}: a line is a phrase, a tab, and as many numbers as the other lines have", source_name, number));
    }
    for (float& v : vector) {
      v = static_cast<float>(v / norm);
    }
    size = vector.size();
    table.vectors_[line.substr(0, tab)] = std::move(vector);
  }
  return Result<Embeddings>::ok(std::move(table));
}

const std::vector<float>* Embeddings::find(const std::string& phrase) const {
  const auto it = vectors_.find(phrase);
  return it != vectors_.end() ? &it->second : nullptr;
}

double Embeddings::similarity(const std::string& a, const std::string& b) const {
  const std::vector<float>*va = find(a), *vb = find(b);
  return va != nullptr && vb != nullptr ? std::inner_product(va->begin(), va->end(), vb->begin(), 0.0) : 0;
}

}  // namespace hgg
