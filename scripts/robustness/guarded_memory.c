/* SPDX-License-Identifier: BSD-3-Clause */
/* Preloaded into a program as it is, with all of its optimisation: finds what is read or written beyond a block of
 * memory.
 *
 *   LD_PRELOAD=guarded_memory.so build/bin/hrp-diagnose ...
 *
 * Each block ends at a page that nobody may touch, so whatever reads or writes behind it ends there with the places of
 * the calls. Up to 15 bytes between a block and that page, and 64 before the block, are looked at when it is freed.
 * Fresh and freed memory is full of 0xff: numbers that were never set are NaN, pointers lead nowhere. It takes up to
 * twice as long, and a page for each small block. Not seen: indices that land in another block, and blocks beyond the
 * first 31 000 at a time (Linux allows 65 530 pieces of memory in a process).
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { kPage = 4096, kAlign = 16, kBefore = 64, kSlots = 31000, kClasses = 24, kUnset = 0xff };
#define ARENA (1ul << 36)  /* bytes of addresses, not of memory */
#define FILLED (1ul << 18) /* bytes: larger blocks are filled at their start only */

/* A place for blocks of up to 2^class pages, followed by a page that nobody may touch. */
struct Slot {
  size_t size; /* of the block that is or was there */
  uint32_t page, class, next_free, used;
};

static char* arena;
static uint32_t* slot_of_page;
static struct Slot slots[kSlots]; /* 0: none */
static uint32_t num_slots = 1, num_pages, free_slot[kClasses];
static char lock;

extern void* __libc_malloc(size_t size);
extern void* __libc_realloc(void* block, size_t size);
extern void* __libc_memalign(size_t align, size_t size);
extern void __libc_free(void* block);

static void take_lock(void) {
  while (__atomic_test_and_set(&lock, __ATOMIC_ACQUIRE)) continue;
}
static void give_lock(void) { __atomic_clear(&lock, __ATOMIC_RELEASE); }
static size_t min_size(size_t a, size_t b) { return a < b ? a : b; }
static char* get_start(const struct Slot* s) { return arena + (size_t)s->page * kPage; }
static char* get_end(const struct Slot* s) { return get_start(s) + ((size_t)kPage << s->class); }
static int is_guarded(const void* block) {
  return arena != NULL && (const char*)block >= arena && (const char*)block < arena + ARENA;
}
static struct Slot* get_slot(const void* block) { return &slots[slot_of_page[((const char*)block - arena) / kPage]]; }

static void end_with(const char* what) {
  void* calls[64];
  if (write(2, what, strlen(what)) >= 0) backtrace_symbols_fd(calls, backtrace(calls, 64), 2);
  signal(SIGABRT, SIG_DFL);
  abort();
}

static void say_touched(int number, siginfo_t* info, void* context) {
  (void)context;
  char text[160] = "guarded memory: an address that is not there was used\n";
  const char* address = info->si_addr;
  signal(number, SIG_DFL);
  if (is_guarded(address) && address >= arena + kPage) {
    const struct Slot* s = &slots[slot_of_page[(address - arena) / kPage - 1]];
    snprintf(text, sizeof text, "guarded memory: byte %ld of a block of %zu bytes was used\n",
             (long)(address - get_end(s)) + (long)s->size, s->size);
  }
  end_with(text);
}

__attribute__((constructor)) static void watch(void) {
  struct sigaction action;
  void* calls[2];
  backtrace(calls, 2); /* loads its library now, not in a signal */
  memset(&action, 0, sizeof action);
  action.sa_sigaction = say_touched;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGSEGV, &action, NULL);
  sigaction(SIGBUS, &action, NULL);
}

static void* reserve(size_t size, int access) {
  void* there = mmap(NULL, size, access, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (there == MAP_FAILED) end_with("guarded memory: no addresses are left\n");
  return there;
}

/* A free slot of this class, or 0. The lock is taken. */
static uint32_t take_slot(uint32_t class) {
  const uint32_t pages = 1u << class, id = free_slot[class];
  if (arena == NULL) {
    slot_of_page = reserve(ARENA / kPage * sizeof *slot_of_page, PROT_READ | PROT_WRITE);
    arena = reserve(ARENA, PROT_NONE);
  }
  if (id != 0) {
    free_slot[class] = slots[id].next_free;
    return id;
  }
  if (num_slots == kSlots || (size_t)(num_pages + pages + 1) * kPage > ARENA) return 0;
  if (mprotect(arena + (size_t)num_pages * kPage, (size_t)pages * kPage, PROT_READ | PROT_WRITE) != 0) return 0;
  slots[num_slots] = (struct Slot){0, num_pages, class, 0, 0};
  for (uint32_t k = 0; k <= pages; ++k) slot_of_page[num_pages + k] = num_slots;
  num_pages += pages + 1;
  return num_slots++;
}

/* NULL where no slot is left. */
static void* guard(size_t size, size_t align) {
  const size_t room = size == 0 ? align : (size + align - 1) / align * align;
  uint32_t class = 0;
  while (((size_t)kPage << class) < room) {
    if (++class == kClasses) return NULL;
  }
  take_lock();
  struct Slot* s = &slots[take_slot(class)];
  if (s != slots) {
    s->size = size;
    s->used = 1;
  }
  give_lock();
  if (s == slots) return NULL;
  char* block = get_end(s) - room;
  const size_t before = min_size(kBefore, (size_t)(block - get_start(s)));
  memset(block - before, kUnset, before + min_size(room, FILLED));
  memset(block + size, kUnset, room - size);
  return block;
}

static void release(char* block) {
  struct Slot* s = get_slot(block);
  if (!s->used) end_with("guarded memory: a block was freed twice\n");
  const size_t before = min_size(kBefore, (size_t)(block - get_start(s)));
  for (const char* p = block - before; p < block; ++p) {
    if (*p != (char)kUnset) end_with("guarded memory: it was written before a block\n");
  }
  for (const char* p = block + s->size; p < get_end(s); ++p) {
    if (*p != (char)kUnset) end_with("guarded memory: it was written behind a block\n");
  }
  memset(block, kUnset, s->size);
  take_lock();
  s->used = 0;
  s->next_free = free_slot[s->class];
  free_slot[s->class] = (uint32_t)(s - slots);
  give_lock();
}

void* malloc(size_t size) {
  void* block = guard(size, kAlign);
  return block != NULL ? block : __libc_malloc(size);
}

void free(void* block) {
  const int error = errno;
  if (is_guarded(block))
    release(block);
  else
    __libc_free(block);
  errno = error;
}

void* calloc(size_t count, size_t size) {
  size_t all;
  void* block = __builtin_mul_overflow(count, size, &all) ? NULL : malloc(all);
  if (block == NULL)
    errno = ENOMEM;
  else
    memset(block, 0, all);
  return block;
}

void* realloc(void* block, size_t size) {
  if (block != NULL && !is_guarded(block)) return __libc_realloc(block, size);
  void* moved = block != NULL && size == 0 ? NULL : malloc(size);
  if (block == NULL || (moved == NULL && size != 0)) return moved;
  if (moved != NULL) memcpy(moved, block, min_size(size, get_slot(block)->size));
  free(block);
  return moved;
}

void* memalign(size_t align, size_t size) {
  void* block = align <= kPage ? guard(size, align < kAlign ? kAlign : align) : NULL;
  return block != NULL ? block : __libc_memalign(align, size);
}

void* aligned_alloc(size_t align, size_t size) { return memalign(align, size); }

int posix_memalign(void** block, size_t align, size_t size) {
  *block = memalign(align, size);
  return *block == NULL ? ENOMEM : 0;
}

size_t malloc_usable_size(void* block) {
  if (is_guarded(block)) return get_slot(block)->size;
  size_t (*real)(void*) = (size_t(*)(void*))dlsym(RTLD_NEXT, "malloc_usable_size");
  return real(block);
}
