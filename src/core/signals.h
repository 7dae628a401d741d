#pragma once

namespace hgg {

/// Blocks all signals in the calling thread, so that they reach the main thread, which knows what to do about them. To
/// be called first by any other thread: there they would only interrupt what it waits for.
void leaveSignalsToMainThread();

}  // namespace hgg
