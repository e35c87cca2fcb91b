#pragma once

#include <pthread.h>
#include <sched.h>

#include "twin/rt/thread_setup.h"

namespace twin::test {

/// What a thread needs to hold its own beside other load, where the machine permits it.
inline rt::ThreadSettings Urgent(const char* name, int priority) {
  rt::ThreadSettings settings;
  settings.name = name;
  settings.fifo_priority = priority;
  settings.lock_memory = false;
  settings.stack_kb = 0;
  return settings;
}

/// Of the thread that a test runs on; a robot in real time has more.
inline constexpr int kUrgentHere = 80;

/// Makes the calling thread urgent while it lives.
class UrgentHere {
 public:
  UrgentHere() {
    pthread_getschedparam(pthread_self(), &policy_, &parameters_);
    static_cast<void>(rt::SetUpThisThread(Urgent("", kUrgentHere)));
  }
  ~UrgentHere() { pthread_setschedparam(pthread_self(), policy_, &parameters_); }
  UrgentHere(const UrgentHere&) = delete;
  UrgentHere& operator=(const UrgentHere&) = delete;

 private:
  int policy_ = SCHED_OTHER;
  sched_param parameters_{};
};

}  // namespace twin::test
