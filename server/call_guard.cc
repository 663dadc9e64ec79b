#include "server/call_guard.h"

#include <grpcpp/server.h>

#include <atomic>
#include <map>
#include <memory>

#include "core/base/mutex.h"
#include "server/call_heads.h"
#include "server/handlers/held_calls.h"

namespace axiscal::server {
namespace {

using handlers::HeldCall;
using handlers::HeldKind;

// gRPC has one such object a process, tells it no server, and calls it on the thread that serves the call: the reply
// has been sent between handler and PostSynchronousRequest().
class Guard final : public grpc::Server::GlobalCallbacks {
 public:
  int SetLimits(const handlers::HeldLimits& held) {
    const base::MutexLock lock(mutex_);
    limits_ = held;
    // Calls that are in a handler count here too.
    limits_.max_replies += held.max_uploads + held.max_downloads + held.max_watches + held.max_rewrites;
    return limits_.max_replies;
  }
  void PreSynchronousRequest(grpc::ServerContext* context) override {
    CallHeads::Hear(*context);
    ++begun_;  // before the lock, where a flood waits
    const base::MutexLock lock(mutex_);
    auto call = std::make_unique<HeldCall>(held_, limits_, HeldKind::kReply, [context] { context->TryCancel(); });
    call->BeginSilence();
    calls_[context] = std::move(call);
  }
  void PostSynchronousRequest(grpc::ServerContext* context) override {
    const base::MutexLock lock(mutex_);
    calls_.erase(context);
  }
  int64_t unheard() const { return begun_ - heard_; }
  // Null for a call that is not guarded. Stays until PostSynchronousRequest().
  HeldCall* Find(grpc::ServerContext* context) {
    const base::MutexLock lock(mutex_);
    const auto found = calls_.find(context);
    return found == calls_.end() ? nullptr : found->second.get();
  }
  void Hear() { ++heard_; }

 private:
  std::atomic<int64_t> begun_ = 0, heard_ = 0;  // calls, and those that came to a handler of ours
  handlers::HeldCalls held_;
  base::Mutex mutex_;
  handlers::HeldLimits limits_ AXISCAL_GUARDED_BY(mutex_);
  std::map<grpc::ServerContext*, std::unique_ptr<HeldCall>> calls_ AXISCAL_GUARDED_BY(mutex_);
};

// Never destroyed: gRPC may call it as long as there are servers.
Guard& TheGuard() {
  static Guard& guard = *[] {
    auto* made = new Guard;
    grpc::Server::SetGlobalCallbacks(made);
    return made;
  }();
  return guard;
}

}  // namespace

int GuardCalls(const handlers::HeldLimits& held) { return TheGuard().SetLimits(held); }

int64_t UnheardCalls() { return TheGuard().unheard(); }

InHandler::InHandler(grpc::ServerContext* context) : context_(context) {
  TheGuard().Hear();
  if (HeldCall* const call = TheGuard().Find(context)) call->EndSilence();
}

InHandler::~InHandler() {
  if (HeldCall* const call = TheGuard().Find(context_)) call->BeginSilence();
}

}  // namespace axiscal::server
