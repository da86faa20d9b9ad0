/* SPDX-License-Identifier: BSD-3-Clause */
/* Preloaded into a run: a system of which one thing is faulty, for the program HRP_FAULT_PROGRAM or, without it, for
 * all.
 *
 *   HRP_FAULT_MALLOC=N or N+     the N-th allocation from main() on fails, with + all later ones, too
 *   HRP_FAULT_CLOCK=apart|jumps  the wall clock is wrong by up to an hour, another error in each process or at each
 * look HRP_FAULT_READ=N             the N-th read() of an input file, and all later ones, fail: the disk is bad (EIO)
 *   HRP_FAULT_SLOW=T             each write into a log takes T more [us]
 *   HRP_FAULT_READ_ONLY=1        no log can be made: the file system is read-only
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static atomic_long allocations_left = -1; /* -1: none fails */
static atomic_long reads_left = -1;       /* -1: none fails */
static int fails_for_good;
static int jumps;
static long clock_error; /* [s] */
static long slow;        /* [us] */
static int read_only;

static unsigned long mix(unsigned long x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ul;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebul;
  return x ^ (x >> 31);
}

static long draw_error(unsigned long seed) { return (long)(mix(seed) % 7200) - 3600; }

__attribute__((constructor)) static void read_faults(void) {
  const char* program = getenv("HRP_FAULT_PROGRAM");
  if (program != NULL && strcmp(program, program_invocation_short_name) != 0) return;
  const char* word = getenv("HRP_FAULT_CLOCK");
  if (word != NULL) {
    jumps = strcmp(word, "jumps") == 0;
    if (!jumps) clock_error = draw_error((unsigned long)getpid());
  }
  if ((word = getenv("HRP_FAULT_SLOW")) != NULL) slow = atol(word);
  read_only = getenv("HRP_FAULT_READ_ONLY") != NULL;
  if ((word = getenv("HRP_FAULT_READ")) != NULL) atomic_store(&reads_left, atol(word));
}

/* Libraries that prepare themselves before main() can tell nobody that there is no memory: counted from main() on. */
static int (*real_main)(int, char**, char**);

static int start_counting(int argc, char** argv, char** environment) {
  const char* program = getenv("HRP_FAULT_PROGRAM");
  const char* word = getenv("HRP_FAULT_MALLOC");
  if (word != NULL && (program == NULL || strcmp(program, program_invocation_short_name) == 0)) {
    fails_for_good = word[strlen(word) - 1] == '+';
    atomic_store(&allocations_left, atol(word));
  }
  return real_main(argc, argv, environment);
}

int __libc_start_main(int (*entry)(int, char**, char**), int argc, char** argv, void (*begin)(void), void (*end)(void),
                      void (*end_of_loader)(void), void* stack) {
  int (*start)(int (*)(int, char**, char**), int, char**, void (*)(void), void (*)(void), void (*)(void), void*) =
      dlsym(RTLD_NEXT, "__libc_start_main");
  real_main = entry;
  return start(start_counting, argc, argv, begin, end, end_of_loader, stack);
}

/* ---- memory ---- */

void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* old, size_t size);

static int fails_now(void) {
  long left = atomic_load(&allocations_left);
  do {
    if (left < 0) return 0;
  } while (!atomic_compare_exchange_weak(&allocations_left, &left, left > 0 || !fails_for_good ? left - 1 : 0));
  if (left > 0) return 0;
  errno = ENOMEM;
  return 1;
}

void* malloc(size_t size) { return fails_now() ? NULL : __libc_malloc(size); }
void* calloc(size_t count, size_t size) { return fails_now() ? NULL : __libc_calloc(count, size); }
void* realloc(void* old, size_t size) { return fails_now() ? NULL : __libc_realloc(old, size); }

/* ---- clock ---- */

static long find_error(void) {
  static atomic_ulong looks;
  return jumps ? draw_error(atomic_fetch_add(&looks, 1)) : clock_error;
}

int clock_gettime(clockid_t clock, struct timespec* now) {
  const int result = (int)syscall(SYS_clock_gettime, clock, now);
  if (result == 0 && clock == CLOCK_REALTIME) now->tv_sec += find_error();
  return result;
}

int gettimeofday(struct timeval* restrict now, void* restrict zone) {
  struct timespec exact;
  (void)zone;
  clock_gettime(CLOCK_REALTIME, &exact);
  now->tv_sec = exact.tv_sec;
  now->tv_usec = exact.tv_nsec / 1000;
  return 0;
}

time_t time(time_t* out) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (out != NULL) *out = now.tv_sec;
  return now.tv_sec;
}

/* Waits until a time of the wrong clock. The functions with a clock of their own keep the name of the right one. */
int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock,
                           const struct timespec* until);
int sem_clockwait(sem_t* semaphore, clockid_t clock, const struct timespec* until);
int pthread_mutex_clocklock(pthread_mutex_t* mutex, clockid_t clock, const struct timespec* until);

static struct timespec make_right(const struct timespec* until) {
  struct timespec right = *until;
  if (!jumps) right.tv_sec -= clock_error;
  return right;
}

int sem_timedwait(sem_t* restrict semaphore, const struct timespec* restrict until) {
  const struct timespec right = make_right(until);
  return sem_clockwait(semaphore, CLOCK_REALTIME, &right);
}

int pthread_mutex_timedlock(pthread_mutex_t* restrict mutex, const struct timespec* restrict until) {
  const struct timespec right = make_right(until);
  return pthread_mutex_clocklock(mutex, CLOCK_REALTIME, &right);
}

/* Conditions may be set to the steady clock, whose times are hours or days: those stay as they are. */
int pthread_cond_timedwait(pthread_cond_t* restrict condition, pthread_mutex_t* restrict mutex,
                           const struct timespec* restrict until) {
  struct timespec steady, right = make_right(until);
  syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &steady);
  if (until->tv_sec < steady.tv_sec + 1000000000)
    return pthread_cond_clockwait(condition, mutex, CLOCK_MONOTONIC, until);
  return pthread_cond_clockwait(condition, mutex, CLOCK_REALTIME, &right);
}

/* ---- disk ---- */

static int ends_with(const char* path, const char* end) {
  const size_t size = strlen(path), length = strlen(end);
  return size > length && strcmp(path + size - length, end) == 0;
}

static int is_log(const char* path) { return ends_with(path, ".mcap"); }

static int is_input(const char* path) {
  return ends_with(path, ".yaml") || ends_with(path, ".urdf") || ends_with(path, ".csv") || ends_with(path, ".seq");
}

/* Whether the open file has such a name. */
static int is_named(int file, int (*fits)(const char* path)) {
  char link[64], path[4096];
  snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  if (length <= 0) return 0;
  path[length] = '\0';
  return fits(path);
}

ssize_t write(int file, const void* data, size_t size) {
  if (slow > 0 && is_named(file, is_log)) usleep((useconds_t)slow);
  return syscall(SYS_write, file, data, size);
}

ssize_t read(int file, void* data, size_t size) {
  if (atomic_load(&reads_left) >= 0 && is_named(file, is_input)) {
    if (atomic_load(&reads_left) <= 1) {
      errno = EIO;
      return -1;
    }
    atomic_fetch_sub(&reads_left, 1);
  }
  return syscall(SYS_read, file, data, size);
}

int open(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE ? va_arg(list, mode_t) : 0;
  va_end(list);
  if (read_only && (flags & (O_WRONLY | O_RDWR)) != 0 && is_log(path)) {
    errno = EROFS;
    return -1;
  }
  return (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}

/* A log that was written without a name gets it here. */
int linkat(int from, const char* old, int to, const char* path, int flags) {
  if (read_only && is_log(path)) {
    errno = EROFS;
    return -1;
  }
  return (int)syscall(SYS_linkat, from, old, to, path, flags);
}

int open64(const char* path, int flags, ...) __attribute__((alias("open")));
