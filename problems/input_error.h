// Bad input: of a file, of an option or of a problem that is put together in memory. Exit status 2.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace sagitta {

class InputError : public std::runtime_error {
 public:
  // Any part may be empty (line 0: none). `hint` says what to do about it. file: of a row that is of no file, what it
  // is called instead (Measurements::SourceOf).
  struct Where {
    std::string file;
    int line = 0;
    std::string key;
  };
  InputError(Where where, const std::string& what, const std::string& hint = "");

  const Where& where() const { return where_; }
  const std::string& hint() const { return hint_; }

 private:
  Where where_;
  std::string hint_;
};

// How far a name is from a candidate: 0 equal but for case and punctuation, 1
// another unit (x_cm for x_mm), above: 1 + Levenshtein distance; -1: not near.
int NameDistance(const std::string& name, const std::string& candidate);

// A column name is likely meant to be the listed one. Extra columns are welcome: dx_mm is not x_mm, rotation is not
// station.
bool IsSlipOfColumn(const std::string& name, const std::string& listed);

// d_mm is no misspelt a_mm, nor a_y_mm an a_x_mm: words of one letter differ, and nothing else.
bool IsAnotherLetter(const std::string& name, const std::string& other);

// The candidate that a misspelt name is nearest to (Levenshtein distance), ""
// when none is near enough to be meant.
std::string NearestName(const std::string& name, const std::vector<std::string>& candidates);

// "did you mean 'x'?" or "known: a, b, c".
std::string SpellingHint(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace sagitta
