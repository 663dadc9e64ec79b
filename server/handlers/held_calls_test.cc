#include "server/handlers/held_calls.h"

#include <gtest/gtest.h>

#include <future>

#include "core/base/error_detail.h"
#include "core/base/testing/fake_clock.h"

namespace axiscal::handlers {
namespace {

using std::chrono::milliseconds;

constexpr HeldLimits kLimits = {
    .max_uploads = 2, .max_downloads = 1, .max_watches = 1, .max_rewrites = 2, .max_replies = 1};

// A call whose caller says nothing, in a thread as a server has it: ends when it is cut off or released.
class SilentCall {
 public:
  SilentCall(HeldCalls& calls, HeldKind kind)
      : call_(calls, kLimits, kind, [this] { Release(); }), thread_([this] {
          call_.Await([this] {
            waits_.set_value();
            end_.get_future().wait();
            return false;
          });
          ended_.set_value();
        }) {
    waits_.get_future().wait();
  }
  ~SilentCall() {
    Release();
    thread_.join();
  }
  void Release() {
    if (!is_released_.exchange(true)) end_.set_value();
  }
  absl::Status AwaitEnd() {
    ended_.get_future().wait();
    return call_.status();
  }

 private:
  std::promise<void> waits_, end_, ended_;
  std::atomic<bool> is_released_ = false;
  HeldCall call_;
  std::thread thread_;
};

class HeldCallsTest : public ::testing::Test {
 protected:
  base::FakeClock clock_;
  HeldCalls calls_{&clock_};
};

TEST_F(HeldCallsTest, WhoIsSilentForTooLongIsCutOff) {
  SilentCall silent(calls_, HeldKind::kUpload);
  clock_.Advance(kLimits.silence - milliseconds(1));
  HeldCall busy(calls_, kLimits, HeldKind::kUpload, [] { ADD_FAILURE(); });
  EXPECT_TRUE(busy.Await([] { return true; }));
  EXPECT_EQ(calls_.count(HeldKind::kUpload), 2);
  clock_.Advance(milliseconds(1));
  EXPECT_EQ(base::ErrorReason(silent.AwaitEnd()), "DEADLINE");
  EXPECT_EQ(calls_.count(HeldKind::kUpload), 1);
  clock_.Advance(10 * kLimits.silence);  // a server that works for its caller is not a silent caller
  EXPECT_TRUE(busy.status().ok());
}

TEST_F(HeldCallsTest, MoreThanTheLimitOfAKindAreRefused) {
  const SilentCall first(calls_, HeldKind::kUpload), second(calls_, HeldKind::kUpload);
  HeldCall third(calls_, kLimits, HeldKind::kUpload, [] {});
  EXPECT_EQ(third.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(third.status().message(), "more than 2 uploads at a time");
  EXPECT_EQ(base::ErrorReason(third.status()), "QUEUE_FULL");
  EXPECT_EQ(calls_.count(HeldKind::kUpload), 2);
  // Other kinds have places of their own.
  EXPECT_TRUE(HeldCall(calls_, kLimits, HeldKind::kDownload, [] {}).status().ok());
  EXPECT_TRUE(HeldCall(calls_, kLimits, HeldKind::kWatch, [] {}).status().ok());
}

TEST_F(HeldCallsTest, OnePrincipalLeavesPlacesToOthers) {
  HeldLimits limits = kLimits;
  limits.max_uploads = 10;
  limits.max_of_one = 2;
  const auto of = [&](const std::string& who) {
    return std::make_unique<HeldCall>(
        calls_, limits, HeldKind::kUpload, [] {}, who);
  };
  std::unique_ptr<HeldCall> first = of("eve"), second = of("eve");
  const std::unique_ptr<HeldCall> third = of("eve");
  EXPECT_EQ(third->status().message(), "more than 2 uploads of eve at a time");
  EXPECT_EQ(base::ErrorReason(third->status()), "QUEUE_FULL");
  EXPECT_TRUE(of("bob")->status().ok());
  EXPECT_EQ(calls_.count(HeldKind::kUpload), 2);
  EXPECT_TRUE(HeldCall(
                  calls_, limits, HeldKind::kDownload, [] {}, "eve")
                  .status()
                  .ok());
  first.reset();
  EXPECT_TRUE(of("eve")->status().ok());
}

TEST_F(HeldCallsTest, TheOneSilentLongestGivesWayWhereAllPlacesAreTaken) {
  SilentCall first(calls_, HeldKind::kUpload);
  clock_.Advance(milliseconds(1));
  const SilentCall second(calls_, HeldKind::kUpload);
  clock_.Advance(kLimits.gives_way);
  EXPECT_TRUE(HeldCall(calls_, kLimits, HeldKind::kDownload, [] {}).status().ok());
  EXPECT_EQ(calls_.count(HeldKind::kUpload), 2) << "a place of another kind needs none of theirs";
  HeldCall third(calls_, kLimits, HeldKind::kUpload, [] {});
  EXPECT_TRUE(third.status().ok()) << third.status();
  EXPECT_EQ(base::ErrorReason(first.AwaitEnd()), "DEADLINE");
  EXPECT_EQ(calls_.count(HeldKind::kUpload), 2);
}

// Programs that are rewritten take a core each: callers that send nothing do not keep the places of those that do.
TEST_F(HeldCallsTest, WhoSendsNoProgramGivesWayToWhoDoes) {
  SilentCall first(calls_, HeldKind::kRewrite);
  const SilentCall second(calls_, HeldKind::kRewrite);
  {
    const HeldCall third(calls_, kLimits, HeldKind::kRewrite, [] {});
    EXPECT_EQ(third.status().message(), "more than 2 programs are rewritten at a time");
  }
  EXPECT_EQ(calls_.count(HeldKind::kUpload), 0) << "and no place of an upload";
  clock_.Advance(kLimits.gives_way);
  const HeldCall third(calls_, kLimits, HeldKind::kRewrite, [] {});
  EXPECT_TRUE(third.status().ok()) << third.status();
  EXPECT_EQ(base::ErrorReason(first.AwaitEnd()), "DEADLINE");
  EXPECT_EQ(calls_.count(HeldKind::kRewrite), 2);
}

TEST_F(HeldCallsTest, NoReplyIsRefused) {
  SilentCall first(calls_, HeldKind::kReply);
  EXPECT_TRUE(HeldCall(calls_, kLimits, HeldKind::kReply, [] {}).status().ok());
  EXPECT_EQ(calls_.count(HeldKind::kReply), 1);
  clock_.Advance(kLimits.gives_way);
  EXPECT_TRUE(HeldCall(calls_, kLimits, HeldKind::kReply, [] {}).status().ok());
  EXPECT_EQ(base::ErrorReason(first.AwaitEnd()), "DEADLINE");
  EXPECT_EQ(calls_.count(HeldKind::kReply), 0);
}

TEST_F(HeldCallsTest, WhoWasCutOffAndWaitsAgainIsCountedOnce) {
  SilentCall first(calls_, HeldKind::kUpload);
  {
    std::promise<void> cut_off;
    HeldCall twice(calls_, kLimits, HeldKind::kUpload, [&] { cut_off.set_value(); });
    for (int i = 0; i < 2; ++i) {
      twice.BeginSilence();
      clock_.Advance(kLimits.silence);
      cut_off.get_future().wait();
      twice.EndSilence();
      cut_off = std::promise<void>();
    }
    EXPECT_EQ(base::ErrorReason(first.AwaitEnd()), "DEADLINE");
  }
  EXPECT_EQ(calls_.count(HeldKind::kUpload), 0);
}

TEST_F(HeldCallsTest, AnEndedCallLeavesItsPlace) {
  {
    const HeldCall call(calls_, kLimits, HeldKind::kWatch, [] {});
    EXPECT_EQ(calls_.count(HeldKind::kWatch), 1);
    EXPECT_FALSE(HeldCall(calls_, kLimits, HeldKind::kWatch, [] {}).status().ok());
  }
  EXPECT_EQ(calls_.count(HeldKind::kWatch), 0);
  EXPECT_TRUE(HeldCall(calls_, kLimits, HeldKind::kWatch, [] {}).status().ok());
}

// One that is rewritten holds a core: who sends a byte every few seconds is never silent for long, and gives way all
// the same; one that is at work most of the time does not.
TEST_F(HeldCallsTest, WhoHoldsACoreAndSendsNextToNothingGivesWay) {
  bool is_slow_cut = false;
  HeldCall slow(calls_, kLimits, HeldKind::kRewrite, [&] { is_slow_cut = true; });
  HeldCall busy(calls_, kLimits, HeldKind::kRewrite, [] { ADD_FAILURE() << "the one at work was cut off"; });
  const auto is_refused = [&] { return !HeldCall(calls_, kLimits, HeldKind::kRewrite, [] {}).status().ok(); };
  for (milliseconds waited(0); waited < milliseconds(9000); waited += milliseconds(1000)) {
    slow.BeginSilence();
    clock_.Advance(milliseconds(970));
    slow.EndSilence();
    clock_.Advance(milliseconds(30));
    busy.BeginSilence();
    busy.EndSilence();
  }
  busy.BeginSilence();
  slow.BeginSilence();
  EXPECT_TRUE(is_refused());  // not for kLimits.gives_way yet
  EXPECT_FALSE(is_slow_cut);
  clock_.Advance(milliseconds(2000));
  EXPECT_FALSE(is_refused());
  EXPECT_TRUE(is_slow_cut);
  slow.EndSilence();
  busy.EndSilence();
}

}  // namespace
}  // namespace axiscal::handlers
