// What options that take a number above 0 say of anything else.
#ifndef AXISCAL_CLIENT_CLI_POSITIVE_NUMBER_H_
#define AXISCAL_CLIENT_CLI_POSITIVE_NUMBER_H_

#include <CLI/CLI.hpp>

namespace axiscal::cli {

// As CLI::PositiveNumber, whose words are the limits of a double.
CLI::Validator PositiveNumber();

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_POSITIVE_NUMBER_H_
