#pragma once

#include <memory>

#include "twin/loop/drive.h"

namespace twin::loop {

/// As MakeRemoteDrive, of a robot whose states are its time. One thread, the caller's, reads,
/// computes and writes; it waits for states as long as the robot waits for commands, and no time
/// passes meanwhile. A motion that starts at a given state repeats, whatever the machine does: it
/// gives the same commands, and the same log except for how many states came before it.
///
/// Run() refuses the synchronous loop with an InputError: it sleeps on a clock of its own. Every
/// state is answered, whatever TickConfig::period_tolerance says: the robot would wait otherwise.
[[nodiscard]] std::unique_ptr<Drive> MakeStateTimeDrive(const backend::Factory& connect,
                                                        const robot::RobotConfig& robot,
                                                        rt::RecordSink* sink,
                                                        const backend::RobotAddress& address);

}  // namespace twin::loop
