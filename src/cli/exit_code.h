#pragma once

namespace twin::cli {

/// What the program returns.
enum ExitCode : int {
  kOk = 0,
  kFailed = 1,       ///< the run aborted, or a check failed
  kUsage = 2,        ///< the command line is wrong
  kBadInput = 3,     ///< a file or a value is not acceptable
  kEnvironment = 4,  ///< the host lacks something
  kInterrupted = 130,
};

}  // namespace twin::cli
