#include "core/signals.h"

#include <pthread.h>

#include <csignal>

namespace hgg {

void leaveSignalsToMainThread() {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
}

}  // namespace hgg
