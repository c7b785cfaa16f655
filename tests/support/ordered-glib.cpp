// SPDX-License-Identifier: LGPL-2.1-or-later
// Shows ThreadSanitizer the order that GLib makes: GMutex and GCond wait by futex in a library that
// the sanitizer does not see into, and so do counted references and pools of threads. To be linked
// into a program, whose functions come before those of the libraries; each calls the one behind it.
#if defined(__SANITIZE_THREAD__)
#include <dlfcn.h>
#include <glib-object.h>
#include <gst/gst.h>
#include <sanitizer/tsan_interface.h>

namespace {

template <typename Function>
Function *behind(Function *, const char *name) {
  return reinterpret_cast<Function *>(dlsym(RTLD_NEXT, name));
}

// What the thread of a pool calls, with what was pushed.
struct PoolFunction {
  GFunc call;
  gpointer user_data;
};

} // namespace

#define BEHIND(function)                                                                           \
  static auto *const next = behind(function, #function);                                           \
  next

extern "C" {

void g_mutex_lock(GMutex *mutex) {
  BEHIND(g_mutex_lock)(mutex);
  __tsan_acquire(mutex);
}
gboolean g_mutex_trylock(GMutex *mutex) {
  BEHIND(g_mutex_trylock);
  const gboolean locked = next(mutex);
  if (locked)
    __tsan_acquire(mutex);
  return locked;
}
void g_mutex_unlock(GMutex *mutex) {
  __tsan_release(mutex);
  BEHIND(g_mutex_unlock)(mutex);
}
void g_cond_wait(GCond *cond, GMutex *mutex) {
  __tsan_release(mutex);
  BEHIND(g_cond_wait)(cond, mutex);
  __tsan_acquire(mutex);
}
gboolean g_cond_wait_until(GCond *cond, GMutex *mutex, gint64 end) {
  __tsan_release(mutex);
  BEHIND(g_cond_wait_until);
  const gboolean woken = next(cond, mutex, end);
  __tsan_acquire(mutex);
  return woken;
}

void g_object_unref(gpointer object) {
  __tsan_release(object);
  __tsan_acquire(object); // it may be the last one
  BEHIND(g_object_unref)(object);
}
void gst_object_unref(gpointer object) {
  __tsan_release(object);
  __tsan_acquire(object); // it may be the last one
  BEHIND(gst_object_unref)(object);
}
void gst_mini_object_unref(GstMiniObject *object) {
  __tsan_release(object);
  __tsan_acquire(object);
  BEHIND(gst_mini_object_unref)(object);
}

// The caller gives its reference away; GStreamer may drop it where the sanitizer does not see it.
gboolean gst_pad_push_event(GstPad *pad, GstEvent *event) {
  __tsan_release(event);
  BEHIND(gst_pad_push_event);
  return next(pad, event);
}
gboolean gst_pad_event_default(GstPad *pad, GstObject *parent, GstEvent *event) {
  __tsan_release(event);
  BEHIND(gst_pad_event_default);
  return next(pad, parent, event);
}

// GStreamer frees what it counts in functions of its own. Who gave a reference back came before.
void __sanitizer_free_hook(const volatile void *memory) {
  __tsan_acquire(const_cast<void *>(memory));
}

// The program keeps a function for each pool that it makes.
GThreadPool *g_thread_pool_new(GFunc call, gpointer user_data, gint threads, gboolean exclusive,
                               GError **error) {
  const GFunc in_order = [](gpointer data, gpointer function) {
    __tsan_acquire(data);
    const auto &of_pool = *static_cast<const PoolFunction *>(function);
    of_pool.call(data, of_pool.user_data);
  };
  BEHIND(g_thread_pool_new);
  return next(in_order, new PoolFunction{call, user_data}, threads, exclusive, error);
}
gboolean g_thread_pool_push(GThreadPool *pool, gpointer data, GError **error) {
  __tsan_release(data);
  BEHIND(g_thread_pool_push);
  return next(pool, data, error);
}

} // extern "C"
#endif
