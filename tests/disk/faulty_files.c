/// Files that fail: a library for LD_PRELOAD that counts a program's calls that change files below
/// a folder, and lets one of them, or all from one on, fail. Settings are variables of the
/// environment; without TWIN_FAULT_FOLDER nothing happens.
///
///     TWIN_FAULT_FOLDER   absolute path without symbolic links; calls on files elsewhere pass
///     TWIN_FAULT_PROGRAM  name of the program; its children pass (default: panda-twin)
///     TWIN_FAULT_CALLS    which calls count, such as open,write (default: all): open (for
///     writing),
///                         write, fsync, truncate, rename, link, mkdir, unlink, close (of what was
///                         open for writing)
///     TWIN_FAULT_AT       number of the call that fails, counted from 1; 0 or none: none fails
///     TWIN_FAULT_KIND     number of an error (errno), by which it fails; or short (half is
///     written),
///                         kill (SIGKILL instead of the call), torn (half is written, then SIGKILL)
///     TWIN_FAULT_STICKY   1: and all that follow
///     TWIN_FAULT_REPORT   file to which each counted call adds a line: number, call, path; when it
///                         failed, ! instead of the number
///
/// What libc calls inside of itself is not seen: of a FILE, only fopen and fclose are; C++ streams
/// write by themselves. Thread-safe.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

enum Fault { kNone, kFail, kShort, kKill, kTorn };

static const char* folder;
static const char* calls;
static long at;
static enum Fault kind;
static int error_number;
static int is_sticky;
static int report = -1;
static pid_t process;
static atomic_long count;

static const char* Setting(const char* name, const char* otherwise) {
  const char* value = getenv(name);
  return value != NULL ? value : otherwise;
}

__attribute__((constructor)) static void Begin(void) {
  const char* program = Setting("TWIN_FAULT_PROGRAM", "panda-twin");
  if (strcmp(program_invocation_short_name, program) != 0) return;
  calls = getenv("TWIN_FAULT_CALLS");
  at = atol(Setting("TWIN_FAULT_AT", "0"));
  is_sticky = strcmp(Setting("TWIN_FAULT_STICKY", "0"), "1") == 0;
  const char* how = Setting("TWIN_FAULT_KIND", "0");
  error_number = atoi(how);
  kind = strcmp(how, "short") == 0  ? kShort
         : strcmp(how, "kill") == 0 ? kKill
         : strcmp(how, "torn") == 0 ? kTorn
                                    : kFail;
  const char* path = getenv("TWIN_FAULT_REPORT");
  if (path != NULL) {
    report =
        (int)syscall(SYS_openat, AT_FDCWD, path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  }
  process = getpid();
  folder = getenv("TWIN_FAULT_FOLDER");
}

static int IsCounted(const char* call) {
  if (calls == NULL) return 1;
  const size_t size = strlen(call);
  for (const char* found = strstr(calls, call); found != NULL; found = strstr(found + 1, call)) {
    const char end = found[size];
    if ((found == calls || found[-1] == ',') && (end == ',' || end == '\0')) return 1;
  }
  return 0;
}

static int IsBelow(const char* path) {
  const size_t size = strlen(folder);
  return strncmp(path, folder, size) == 0 && (path[size] == '/' || path[size] == '\0');
}

/// What happens to a call on an absolute path.
static enum Fault FaultOf(const char* call, const char* path) {
  if (!IsBelow(path) || !IsCounted(call) || getpid() != process) return kNone;
  const long number = atomic_fetch_add(&count, 1) + 1;
  const int fails = at > 0 && (number == at || (is_sticky && number > at));
  char line[PATH_MAX + 64];
  const int size = fails ? snprintf(line, sizeof line, "! %s %s\n", call, path)
                         : snprintf(line, sizeof line, "%ld %s %s\n", number, call, path);
  if (report >= 0) syscall(SYS_write, report, line, (size_t)size);
  if (!fails) return kNone;
  if (kind == kKill) kill(getpid(), SIGKILL);
  errno = error_number;
  return kind;
}

/// Path of an open file, or "" when it has none. @param path  PATH_MAX bytes.
static void PathOf(int file, char* path) {
  char link[64];
  snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  const long size = syscall(SYS_readlinkat, AT_FDCWD, link, path, (size_t)PATH_MAX - 1);
  path[size > 0 ? size : 0] = '\0';
}

/// What happens to a call on an open file; one that is open for reading does not count, but a
/// folder, which can be synced, does.
static enum Fault FaultOfFile(const char* call, int file) {
  if (folder == NULL) return kNone;
  const int before = errno;
  char path[PATH_MAX];
  PathOf(file, path);
  const int flags = fcntl(file, F_GETFL);
  errno = before;
  const int is_synced = (flags & O_DIRECTORY) != 0 && strcmp(call, "fsync") == 0;
  if (flags < 0 || ((flags & O_ACCMODE) == O_RDONLY && !is_synced)) return kNone;
  return FaultOf(call, path);
}

static enum Fault FaultOfName(const char* call, int in, const char* name) {
  if (folder == NULL) return kNone;
  char path[2 * PATH_MAX + 2];
  if (name[0] == '/') {
    snprintf(path, sizeof path, "%s", name);
  } else {
    char base[PATH_MAX];
    if (in != AT_FDCWD) {
      PathOf(in, base);
    } else if (getcwd(base, sizeof base) == NULL) {
      return kNone;
    }
    snprintf(path, sizeof path, "%s/%s", base, name);
  }
  return FaultOf(call, path);
}

static int Open(int in, const char* name, int flags, mode_t mode) {
  const int writes = (flags & O_ACCMODE) != O_RDONLY || (flags & O_CREAT) != 0;
  if (writes && FaultOfName("open", in, name) == kFail) return -1;
  return (int)syscall(SYS_openat, in, name, flags, mode);
}

/// The mode is there only when a file may be made.
#define MODE_OF(flags, mode)                      \
  mode_t mode = 0;                                \
  if (((flags) & (O_CREAT | __O_TMPFILE)) != 0) { \
    va_list more;                                 \
    va_start(more, flags);                        \
    mode = va_arg(more, mode_t);                  \
    va_end(more);                                 \
  }

int open(const char* name, int flags, ...) {
  MODE_OF(flags, mode)
  return Open(AT_FDCWD, name, flags, mode);
}

int open64(const char* name, int flags, ...) {
  MODE_OF(flags, mode)
  return Open(AT_FDCWD, name, flags, mode);
}

int openat(int in, const char* name, int flags, ...) {
  MODE_OF(flags, mode)
  return Open(in, name, flags, mode);
}

int openat64(int in, const char* name, int flags, ...) {
  MODE_OF(flags, mode)
  return Open(in, name, flags, mode);
}

int mkostemp(char* name, int flags) {
  static int (*real)(char*, int);
  if (real == NULL) *(void**)&real = dlsym(RTLD_NEXT, "mkostemp");
  return FaultOfName("open", AT_FDCWD, name) == kFail ? -1 : real(name, flags);
}

int mkstemp(char* name) {
  return mkostemp(name, 0);
}

static FILE* OpenStream(const char* as, const char* name, const char* mode) {
  FILE* (*real)(const char*, const char*);
  *(void**)&real = dlsym(RTLD_NEXT, as);
  if (strpbrk(mode, "wa+") != NULL && FaultOfName("open", AT_FDCWD, name) == kFail) return NULL;
  return real(name, mode);
}

FILE* fopen(const char* name, const char* mode) {
  return OpenStream("fopen", name, mode);
}

FILE* fopen64(const char* name, const char* mode) {
  return OpenStream("fopen64", name, mode);
}

int fclose(FILE* stream) {
  static int (*real)(FILE*);
  if (real == NULL) *(void**)&real = dlsym(RTLD_NEXT, "fclose");
  const enum Fault fault = FaultOfFile("close", fileno(stream));
  const int result = real(stream);
  if (fault != kFail) return result;
  errno = error_number;
  return EOF;
}

int close(int file) {
  const enum Fault fault = FaultOfFile("close", file);
  const int result = (int)syscall(SYS_close, file);  // it is closed also when that fails
  if (fault != kFail) return result;
  errno = error_number;
  return -1;
}

/// @returns bytes that a call may write; -1 when it fails.
static ssize_t Allowed(enum Fault fault, size_t size) {
  if (fault == kFail) return -1;
  return (ssize_t)(fault == kShort || fault == kTorn ? (size + 1) / 2 : size);
}

ssize_t write(int file, const void* bytes, size_t size) {
  const enum Fault fault = FaultOfFile("write", file);
  const ssize_t allowed = Allowed(fault, size);
  if (allowed < 0) return -1;
  const ssize_t written = syscall(SYS_write, file, bytes, (size_t)allowed);
  if (fault == kTorn) kill(getpid(), SIGKILL);
  return written;
}

ssize_t pwrite(int file, const void* bytes, size_t size, off_t offset) {
  const enum Fault fault = FaultOfFile("write", file);
  const ssize_t allowed = Allowed(fault, size);
  if (allowed < 0) return -1;
  const ssize_t written = syscall(SYS_pwrite64, file, bytes, (size_t)allowed, offset);
  if (fault == kTorn) kill(getpid(), SIGKILL);
  return written;
}

ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t offset) {
  return pwrite(file, bytes, size, offset);
}

/// A short or torn one writes half of the first part that is not empty.
ssize_t writev(int file, const struct iovec* parts, int number) {
  const enum Fault fault = FaultOfFile("write", file);
  if (fault == kFail) return -1;
  if (fault == kNone) return syscall(SYS_writev, file, parts, number);
  while (number > 1 && parts->iov_len == 0) ++parts, --number;
  const ssize_t written = syscall(SYS_write, file, parts->iov_base, (parts->iov_len + 1) / 2);
  if (fault == kTorn) kill(getpid(), SIGKILL);
  return written;
}

int fsync(int file) {
  return FaultOfFile("fsync", file) == kFail ? -1 : (int)syscall(SYS_fsync, file);
}

int fdatasync(int file) {
  return FaultOfFile("fsync", file) == kFail ? -1 : (int)syscall(SYS_fdatasync, file);
}

int ftruncate(int file, off_t size) {
  return FaultOfFile("truncate", file) == kFail ? -1 : (int)syscall(SYS_ftruncate, file, size);
}

int ftruncate64(int file, off64_t size) {
  return ftruncate(file, size);
}

/// A rename is counted by its source.
int renameat2(int from_in, const char* from, int to_in, const char* to, unsigned flags) {
  if (FaultOfName("rename", from_in, from) == kFail) return -1;
  return (int)syscall(SYS_renameat2, from_in, from, to_in, to, flags);
}

int renameat(int from_in, const char* from, int to_in, const char* to) {
  return renameat2(from_in, from, to_in, to, 0);
}

int rename(const char* from, const char* to) {
  return renameat2(AT_FDCWD, from, AT_FDCWD, to, 0);
}

int linkat(int from_in, const char* from, int to_in, const char* to, int flags) {
  if (FaultOfName("link", to_in, to) == kFail) return -1;
  return (int)syscall(SYS_linkat, from_in, from, to_in, to, flags);
}

int link(const char* from, const char* to) {
  return linkat(AT_FDCWD, from, AT_FDCWD, to, 0);
}

int mkdirat(int in, const char* name, mode_t mode) {
  return FaultOfName("mkdir", in, name) == kFail ? -1 : (int)syscall(SYS_mkdirat, in, name, mode);
}

int mkdir(const char* name, mode_t mode) {
  return mkdirat(AT_FDCWD, name, mode);
}

int unlinkat(int in, const char* name, int flags) {
  return FaultOfName("unlink", in, name) == kFail ? -1
                                                  : (int)syscall(SYS_unlinkat, in, name, flags);
}

int unlink(const char* name) {
  return unlinkat(AT_FDCWD, name, 0);
}

int rmdir(const char* name) {
  return unlinkat(AT_FDCWD, name, AT_REMOVEDIR);
}

int remove(const char* name) {
  const int result =
      (int)syscall(SYS_faccessat, AT_FDCWD, name, F_OK) != 0 ? -1 : unlinkat(AT_FDCWD, name, 0);
  return result != 0 && errno == EISDIR ? rmdir(name) : result;
}
