#pragma once

#include <iostream>
#include <sstream>
#include <string>

namespace palpate {

/// While it lives, what is printed comes here.
class CapturedOutput {
 public:
  CapturedOutput() : out_(std::cout.rdbuf(said_.rdbuf())), error_(std::cerr.rdbuf(complained_.rdbuf())) {}
  ~CapturedOutput() {
    std::cout.rdbuf(out_);
    std::cerr.rdbuf(error_);
  }
  CapturedOutput(const CapturedOutput&) = delete;
  CapturedOutput& operator=(const CapturedOutput&) = delete;

  std::string said() const { return said_.str(); }
  std::string complained() const { return complained_.str(); }

 private:
  std::ostringstream said_, complained_;
  std::streambuf *out_, *error_;
};

}  // namespace palpate
