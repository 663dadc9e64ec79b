// What the fuzz targets share. A target is a source that defines Look(); it is linked with driver.cc.
//
// With clang it is a libFuzzer program:
//   cmake --preset fuzz && cmake --build --preset fuzz
//   tests/fuzz/run nc 60
// as tests/run and tests/long do. Built without, main() looks at the corpus and at seeded mutations of it, the same in
// each run:
//   nc_fuzz tests/fuzz/corpus/nc tests/fuzz/nc.dict ROUNDS
#ifndef AXISCAL_TESTS_FUZZ_DRIVER_H_
#define AXISCAL_TESTS_FUZZ_DRIVER_H_

#include <cstdio>
#include <cstdlib>
#include <string>

namespace axiscal::fuzz {

// Of the target: what must hold for any bytes.
void Look(const std::string& bytes);

}  // namespace axiscal::fuzz

// Ends the program where it does not hold: libFuzzer then keeps the bytes, and main() says where they came from.
#define MUST(condition)                                                                  \
  do {                                                                                   \
    if (!(condition)) {                                                                  \
      std::fprintf(stderr, "%s:%d: %s does not hold\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                      \
    }                                                                                    \
  } while (false)

#endif  // AXISCAL_TESTS_FUZZ_DRIVER_H_
