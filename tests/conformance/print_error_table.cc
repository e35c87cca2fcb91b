// Prints the error table as Markdown.

#include <cstdio>

#include "conformance/error_table.h"

int main() {
  std::fputs(twin::test::Markdown(twin::test::ErrorTable()).c_str(), stdout);
  return 0;
}
