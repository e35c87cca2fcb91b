#pragma once

#include <functional>

namespace twin::python {

/// Does `work` on a thread of its own, with the GIL released, while this one waits and handles
/// Python's signals: a handler of the user's runs at once, and one that raises (as Ctrl-C does)
/// sets `interrupted`, which the work polls, and is raised when the work has ended. On the main
/// thread children that the work waits for are given up too (rt::GiveUpWhen); on another thread
/// Python handles no signals, and nothing interrupts the work.
///
/// @pre the GIL is held. @param attend  called every 50 ms with the GIL; what it throws interrupts
/// as a signal does; may be empty. @throws what `attend` or a signal's handler raised, else what
/// `work` threw.
void DoAndWait(volatile bool& interrupted, const std::function<void()>& work,
               const std::function<void()>& attend = {});

}  // namespace twin::python
