#include "twin/rt/thread_setup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <exception>
#include <functional>
#include <string>
#include <thread>

#include "twin/core/error.h"

namespace twin::rt::rt_thread_setup_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// Runs `work` on a thread of its own, so that no setting outlives its test.
void OnAThread(const std::function<void()>& work) {
  std::exception_ptr failure;
  std::thread([&] {
    try {
      work();
    } catch (...) {
      failure = std::current_exception();
    }
  }).join();
  if (failure) std::rethrow_exception(failure);
}

/// Settings that ask for nothing.
ThreadSettings Plain() {
  ThreadSettings settings;
  settings.lock_memory = false;
  settings.stack_kb = 0;
  return settings;
}

std::string RefusalOf(const ThreadSettings& settings) {
  try {
    OnAThread([&] { static_cast<void>(SetUpThisThread(settings)); });
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

int AnAllowedProcessor() {
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  sched_getaffinity(0, sizeof(cpus), &cpus);
  int cpu = 0;
  while (!CPU_ISSET(cpu, &cpus)) ++cpu;
  return cpu;
}

/// Writes to 100 pages of stack below the caller's.
__attribute__((noinline)) void UseStack() {
  volatile char used[400 * 1024];
  for (std::size_t i = 0; i < sizeof(used); i += 4096) used[i] = 1;
}

TEST(ThreadSetupTest, NamesTheThread) {
  OnAThread([] {
    ThreadSettings settings = Plain();
    settings.name = "robot";
    EXPECT_TRUE(SetUpThisThread(settings).empty());
    std::array<char, 16> name{};
    pthread_getname_np(pthread_self(), name.data(), name.size());
    EXPECT_STREQ(name.data(), "robot");
  });
}

TEST(ThreadSetupTest, ChangesNothingThatWasNotAskedFor) {
  OnAThread([] {
    EXPECT_TRUE(SetUpThisThread(Plain()).empty());
    EXPECT_EQ(sched_getscheduler(0), SCHED_OTHER);
  });
}

TEST(ThreadSetupTest, BindsTheThreadToTheProcessor) {
  OnAThread([] {
    ThreadSettings settings = Plain();
    settings.cpu = AnAllowedProcessor();
    EXPECT_TRUE(SetUpThisThread(settings).empty());
    EXPECT_EQ(sched_getcpu(), *settings.cpu);
  });
}

TEST(ThreadSetupTest, TakesThePriorityOrSaysInOneLineThatItDidNot) {
  OnAThread([] {
    ThreadSettings settings = Plain();
    settings.name = "robot";
    settings.fifo_priority = 80;
    const auto notices = SetUpThisThread(settings);
    sched_param parameters{};
    int policy = 0;
    pthread_getschedparam(pthread_self(), &policy, &parameters);
    if (notices.empty()) {
      EXPECT_EQ(policy, SCHED_FIFO);
      EXPECT_EQ(parameters.sched_priority, 80);
    } else {
      EXPECT_EQ(policy, SCHED_OTHER);
      ASSERT_EQ(notices.size(), 1u);
      EXPECT_THAT(notices[0], AllOf(HasSubstr("\"robot\""), HasSubstr("limits.conf")));
    }
  });
}

TEST(ThreadSetupTest, WhatIsNotPermittedIsANoticeWithACureAndNoError) {
  // In a child: a process that has given up its rights cannot take them back.
  EXPECT_EXIT(
      {
        if (geteuid() == 0 && setresuid(65534, 65534, 65534) != 0) _exit(2);
        ThreadSettings settings = Plain();
        settings.name = "robot";
        settings.fifo_priority = 80;
        settings.lock_memory = true;
        rlimit none{};
        setrlimit(RLIMIT_RTPRIO, &none);
        setrlimit(RLIMIT_MEMLOCK, &none);
        const auto notices = SetUpThisThread(settings);
        const bool told = notices.size() == 2 &&
                          notices[0].find("memory is not locked") != std::string::npos &&
                          notices[0].find("memlock") != std::string::npos &&
                          notices[1].find("ordinary scheduler") != std::string::npos &&
                          notices[1].find("rtprio") != std::string::npos;
        for (const auto& notice : notices) std::fprintf(stderr, "%s\n", notice.c_str());
        _exit(told && sched_getscheduler(0) == SCHED_OTHER ? 0 : 1);
      },
      ::testing::ExitedWithCode(0), "limits.conf");
}

TEST(ThreadSetupTest, RefusesAPriorityThatDoesNotExist) {
  for (const int priority : {-1, 100, 1000}) {
    ThreadSettings settings = Plain();
    settings.name = "robot";
    settings.fifo_priority = priority;
    EXPECT_THAT(RefusalOf(settings), AllOf(HasSubstr("robot"), HasSubstr(std::to_string(priority)),
                                           HasSubstr("[1, 99]")));
  }
}

TEST(ThreadSetupTest, RefusesAProcessorThatDoesNotExist) {
  for (const int cpu : {-1, static_cast<int>(sysconf(_SC_NPROCESSORS_CONF)), 100000}) {
    ThreadSettings settings = Plain();
    settings.cpu = cpu;
    EXPECT_THAT(RefusalOf(settings), AllOf(HasSubstr("processor is " + std::to_string(cpu)),
                                           HasSubstr("this machine has 0 to")));
  }
}

TEST(ThreadSetupTest, AStackLargerThanThereIsIsTouchedAsFarAsItGoes) {
  OnAThread([] {
    ThreadSettings settings = Plain();
    settings.stack_kb = 1 << 20;
    EXPECT_TRUE(SetUpThisThread(settings).empty());
  });
}

TEST(ThreadSetupTest, TheTouchedStackCostsNoPageFaultLater) {
  OnAThread([] {
    ThreadSettings settings = Plain();
    settings.stack_kb = 512;
    static_cast<void>(SetUpThisThread(settings));
    rusage before{};
    getrusage(RUSAGE_THREAD, &before);
    UseStack();
    rusage after{};
    getrusage(RUSAGE_THREAD, &after);
    EXPECT_LE(after.ru_minflt - before.ru_minflt, 10);  // the code itself may fault
  });
}

}  // namespace
}  // namespace twin::rt::rt_thread_setup_test
