// The half of jobs.h that workers use: an attempt at a job from its claim to its end.
#include <algorithm>
#include <compare>
#include <string>
#include <vector>

#include "core/base/error_detail.h"
#include "server/storage/calibrations.h"
#include "server/storage/job_owner.h"
#include "server/storage/jobs.h"
#include "server/storage/refusal.h"

namespace axiscal::storage {
namespace {

int64_t LeaseEndUs(const JobOwner& owner, std::chrono::microseconds lease) {
  return owner.lease_now_us + lease.count();
}

// ABORTED LEASE_LOST unless the claim is the present one.
absl::StatusOr<JobRecord> CheckClaim(Connection& connection, const JobOwner& owner, const JobClaim& claim) {
  ASSIGN_OR_RETURN(const JobRecord job, GetJob(connection, claim.id));
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT owner FROM job WHERE id = ?1", claim.id));
  RETURN_IF_ERROR(row.Step().status());
  if (job.state == JobState::kRunning && job.running_attempt == claim.lease_token && row.Text(0) == owner.id)
    return job;
  return base::Error(
      absl::StatusCode::kAborted,
      absl::StrCat("job ", claim.id.number(), ": this attempt has lost its lease (token ", claim.lease_token, ")"),
      {"LEASE_LOST", {{"job", std::to_string(claim.id.number())}}});
}

absl::Status EndAttempt(Connection& connection, UtcTime now, JobId id, int64_t lease_token, const std::string& outcome,
                        const std::string& message) {
  return connection.Run(
      "UPDATE job_attempt SET ended_at_utc_us = ?3, outcome = ?4, message = ?5 WHERE job_id = ?1 AND lease_token = ?2",
      id, lease_token, now, outcome, message);
}

// Of the attempts that `attempt` counts, those whose process died with them.
absl::StatusOr<int> LostOf(Connection& connection, JobId id) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT lost FROM job WHERE id = ?1", id));
  RETURN_IF_ERROR(row.Step().status());
  return static_cast<int>(row.Int(0));
}

// What a job becomes when an attempt ends like this.
JobState NextState(const JobRecord& job, int lost, JobEnd end) {
  if (end == JobEnd::kFailed) return JobState::kFailed;
  if (end == JobEnd::kCancelled || job.cancel_requested) return JobState::kCancelled;
  if (end == JobEnd::kParked) return JobState::kQueued;
  return job.attempt - lost < job.max_attempts && lost < kMostLostAttempts ? JobState::kQueued : JobState::kDead;
}

// Whoever kills a server twice while a job runs there wants nothing of the job. From the third time on the job may be
// what ends its process: the others shall get on in between, and those that were lost together shall not begin together
// again, so that what runs beside such a job does not go with it each time.
std::chrono::microseconds WaitAfterLoss(JobId id, int lost) {
  constexpr int kFreeOfWait = 2, kDoubles = 6, kSteps = 1000;
  constexpr std::chrono::microseconds kFirst = std::chrono::seconds(10);
  if (lost <= kFreeOfWait) return std::chrono::microseconds(0);
  const std::chrono::microseconds wait = kFirst * (1 << std::min(lost - kFreeOfWait - 1, kDoubles));
  // Once to twice that, by the job and the time: any two primes spread them.
  return wait + wait * ((id.number() * 7919 + lost * 104729) % kSteps) / kSteps;
}

std::string WhyLost(int attempt, int lost) {
  const std::string so_far = absl::StrCat("attempt ", attempt, " was not finished: its axiscald ended or stood still, ",
                                          lost, " of at most ", kMostLostAttempts, " times");
  if (lost < kMostLostAttempts) return so_far;
  return so_far +
         "; it may be this job that ends it (by its memory? the server's log and the kernel's tell): make it smaller, "
         "or run it again with axiscal jobs requeue";
}

std::string Name(JobEnd end) {
  switch (end) {
    case JobEnd::kFailed:
      return "FAILED";
    case JobEnd::kCancelled:
      return "CANCELLED";
    case JobEnd::kRetry:
      return "RETRY";
    case JobEnd::kParked:
      return "PARKED";
  }
  return "";
}

absl::Status Leave(Connection& connection, const Moment& now, const JobRecord& job, JobEnd end,
                   const std::string& outcome, const JobError& error, std::chrono::microseconds retry_after) {
  ASSIGN_OR_RETURN(const int lost, LostOf(connection, job.id));
  const JobState next = NextState(job, lost, end);
  const int attempt = end == JobEnd::kParked ? job.attempt - 1 : job.attempt;
  RETURN_IF_ERROR(connection.Run(
      "UPDATE job SET state = ?2, attempt = ?3, owner = NULL, lease_until_steady_us = NULL, waits_from_up_us = ?4, "
      "wait_us = ?5, error_code = ?6, error_reason = ?7, error_message = ?8, ended_at_utc_us = ?9, "
      "version = version + 1 WHERE id = ?1",
      job.id, static_cast<int>(next), attempt, now.up_us, static_cast<int64_t>(retry_after.count()),
      static_cast<int>(error.code), error.reason, error.message, now.utc));
  return EndAttempt(connection, now.utc, job.id, job.running_attempt, outcome, error.message);
}

absl::Status InsertPrograms(Connection& connection, JobId id, const std::vector<ProgramId>& programs) {
  for (size_t i = 0; i < programs.size(); ++i) {
    {
      ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT 1 FROM program WHERE id = ?1 AND state = 2", programs[i]));
      ASSIGN_OR_RETURN(const bool complete, row.Step());
      if (!complete) {
        return FailedPrecondition(absl::StrCat("program ", programs[i].number(), " is not complete"),
                                  "PROGRAM_NOT_COMPLETE");
      }
    }
    RETURN_IF_ERROR(connection.Run("INSERT INTO job_program (job_id, position, program_id) VALUES (?1, ?2, ?3)", id,
                                   static_cast<int64_t>(i), programs[i]));
    RETURN_IF_ERROR(LinkProgram(connection, id, programs[i]));
  }
  return absl::OkStatus();
}

// PERMISSION_DENIED PRINCIPAL_REVOKED: whoever was revoked leaves nothing behind.
absl::Status CheckCreator(Connection& connection, const JobRecord& job) {
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask("SELECT 1 FROM principal WHERE name = ?1 AND revoked_at_utc_us IS NOT NULL", job.created_by));
  ASSIGN_OR_RETURN(const bool is_revoked, row.Step());
  if (!is_revoked) return absl::OkStatus();
  return base::Error(absl::StatusCode::kPermissionDenied,
                     absl::StrCat("job ", job.id.number(), " was created by ", job.created_by,
                                  ", who was revoked: create it again under another name"),
                     {"PRINCIPAL_REVOKED", {{"principal", job.created_by}}});
}

// DEADLINE_EXCEEDED JOB_TOO_LATE: nobody wants it any more.
absl::Status CheckInTime(const Moment& now, const JobRecord& job) {
  if (!job.deadline || *job.deadline > now.utc) return absl::OkStatus();
  return base::Error(absl::StatusCode::kDeadlineExceeded,
                     absl::StrCat("job ", job.id.number(), " was to have ended by its deadline, which is over"),
                     {"JOB_TOO_LATE", {}});
}

absl::Status Fail(Connection& connection, const Moment& now, const JobRecord& job, const absl::Status& why) {
  const JobError error = {why.code(), base::ErrorReason(why), std::string(why.message())};
  return Leave(connection, now, job, JobEnd::kFailed, Name(JobEnd::kFailed), error, std::chrono::microseconds(0));
}

// Waiting jobs whose deadline is over, which fail.
absl::Status FailLate(Connection& connection, const Moment& now, std::vector<JobRecord>& changed) {
  std::vector<JobId> late;
  {
    ASSIGN_OR_RETURN(
        Statement row,
        connection.Ask("SELECT id FROM job INDEXED BY job_waiting_until WHERE state = 1 AND "
                       "deadline_at_utc_us IS NOT NULL AND deadline_at_utc_us <= ?1 ORDER BY deadline_at_utc_us",
                       now.utc));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      late.push_back(JobId(row.Int(0)));
    }
  }
  for (const JobId id : late) {
    ASSIGN_OR_RETURN(const bool waits, HoldWaiting(connection, id));
    if (!waits) continue;
    ASSIGN_OR_RETURN(const JobRecord job, GetJob(connection, id));
    RETURN_IF_ERROR(Fail(connection, now, job, CheckInTime(now, job)));
    ASSIGN_OR_RETURN(changed.emplace_back(), GetJob(connection, id));
  }
  return absl::OkStatus();
}

}  // namespace

namespace {

// What decides whose turn it is; the least one has it.
struct Turn {
  int64_t priority = 0;  // negative: the highest comes first
  int64_t running = 0, last_turn = 0, job = 0;
  std::string whose;

  auto operator<=>(const Turn&) const = default;
};

// Of all whose jobs wait, each once: the first one that may run now, how many of his run, his last turn. One statement
// that seeks four times for each of them, however many jobs they have: an answer of a server takes longer than a seek.
constexpr char kTurns[] = R"(WITH RECURSIVE who (name) AS (
  SELECT (SELECT created_by FROM job INDEXED BY job_waiting_of WHERE state = 1 ORDER BY created_by LIMIT 1)
  UNION ALL
  SELECT (SELECT created_by FROM job INDEXED BY job_waiting_of WHERE state = 1 AND created_by > who.name
    ORDER BY created_by LIMIT 1) FROM who WHERE who.name IS NOT NULL)
SELECT w.name, j.id, j.priority, (SELECT count(*) FROM job WHERE created_by = w.name AND state = 2),
  coalesce((SELECT turn FROM job_turn WHERE created_by = w.name), 0)
FROM (SELECT name, (SELECT id FROM job INDEXED BY job_waiting_of WHERE state = 1 AND created_by = who.name AND
    (wait_us = 0 OR waits_from_up_us + wait_us <= ?1) ORDER BY priority DESC, id LIMIT 1) AS next
  FROM who WHERE name IS NOT NULL) AS w
CROSS JOIN job AS j ON j.id = w.next)";

// Who may have the next turn, in this order: by what is committed at this moment.
absl::StatusOr<std::vector<Turn>> NextTurns(Connection& connection, const Moment& now) {
  std::vector<Turn> turns;
  ASSIGN_OR_RETURN(Statement row, connection.Ask(kTurns, now.up_us));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    turns.push_back({-row.Int(2), row.Int(3), row.Int(4), row.Int(1), row.Text(0)});
  }
  std::sort(turns.begin(), turns.end());
  return turns;
}

// The first waiting job of `whose` that no other one is claiming or ending at this moment, now RUNNING.
absl::StatusOr<std::optional<JobId>> TakeFirstOf(Connection& connection, const std::string& whose,
                                                 const JobOwner& owner, std::chrono::microseconds lease) {
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask(
          "UPDATE job SET state = 2, attempt = attempt + 1, owner = ?3, lease_token = lease_token + 1, "
          "lease_until_steady_us = ?4, started_at_utc_us = ?5, ended_at_utc_us = NULL, progress_stage = '', "
          "progress_fraction = 0.0, progress_detail = '', version = version + 1 WHERE id = (SELECT id FROM job INDEXED "
          "BY job_waiting_of WHERE state = 1 AND created_by = ?1 AND (wait_us = 0 OR waits_from_up_us + wait_us <= ?2) "
          "ORDER BY "
          "priority DESC, id LIMIT 1 /*! FOR UPDATE SKIP LOCKED */) RETURNING id",
          whose, owner.now.up_us, owner.id, LeaseEndUs(owner, lease), owner.now.utc));
  ASSIGN_OR_RETURN(const bool is_taken, row.Step());
  if (!is_taken) return std::nullopt;
  const JobId id(row.Int(0));
  RETURN_IF_ERROR(row.Step().status());
  return id;
}

// Behind the job: whoever waits for the row of a turn holds none that others wait for.
absl::Status NoteTurn(Connection& connection, const std::string& whose) {
  return connection.Run(
      "INSERT INTO job_turn (created_by, turn) VALUES (?1, (SELECT coalesce(max(turn), 0) + 1 FROM job_turn)) ON "
      "CONFLICT (created_by) DO UPDATE SET turn = excluded.turn",
      whose);
}

// The next waiting job, now RUNNING.
absl::StatusOr<std::optional<JobRecord>> ClaimNext(Connection& connection, const JobOwner& owner,
                                                   std::chrono::microseconds lease) {
  ASSIGN_OR_RETURN(const std::vector<Turn> turns, NextTurns(connection, owner.now));
  for (const Turn& turn : turns) {
    ASSIGN_OR_RETURN(const std::optional<JobId> id, TakeFirstOf(connection, turn.whose, owner, lease));
    if (!id.has_value()) continue;
    ASSIGN_OR_RETURN(JobRecord job, GetJob(connection, *id));
    RETURN_IF_ERROR(connection.Run(
        "INSERT INTO job_attempt (job_id, lease_token, attempt, owner, started_at_utc_us) VALUES (?1, ?2, ?3, ?4, ?5)",
        *id, job.running_attempt, job.attempt, owner.id, owner.now.utc));
    RETURN_IF_ERROR(NoteTurn(connection, turn.whose));
    return job;
  }
  return std::nullopt;
}

}  // namespace

absl::StatusOr<std::optional<JobRecord>> ClaimJob(Connection& connection, const JobOwner& owner,
                                                  std::chrono::microseconds lease) {
  while (true) {
    ASSIGN_OR_RETURN(std::optional<JobRecord> job, ClaimNext(connection, owner, lease));
    if (!job.has_value()) return std::nullopt;
    absl::Status status = CheckJobBody(connection, *job);
    if (status.ok()) status = CheckCreator(connection, *job);
    if (status.ok()) status = CheckInTime(owner.now, *job);
    if (status.ok()) return job;
    const bool is_over =
        absl::IsDataLoss(status) || absl::IsPermissionDenied(status) || absl::IsDeadlineExceeded(status);
    if (!is_over) return status;
    RETURN_IF_ERROR(Fail(connection, owner.now, *job, status));
  }
}

absl::StatusOr<std::optional<std::chrono::microseconds>> NextJobWait(Connection& connection, const Moment& now) {
  // Asked often, and however many wait: one that waits for nothing but its turn may be claimed now.
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask(
          "SELECT coalesce((SELECT 0 FROM job INDEXED BY job_waiting WHERE state = 1 AND wait_us = 0 ORDER "
          "BY priority DESC, id LIMIT 1), (SELECT waits_from_up_us + wait_us FROM job INDEXED BY job_delayed "
          "WHERE state = 1 AND wait_us > 0 AND waits_from_up_us + wait_us > 0 ORDER BY waits_from_up_us + wait_us "
          "LIMIT 1))"));
  RETURN_IF_ERROR(row.Step().status());
  if (row.IsNull(0)) return std::nullopt;
  return std::chrono::microseconds(std::max<int64_t>(row.Int(0) - now.up_us, 0));
}

absl::StatusOr<std::vector<std::pair<JobId, int64_t>>> JobVersions(Connection& connection,
                                                                   const std::vector<JobId>& ids) {
  std::vector<int64_t> numbers;
  for (const JobId id : ids) numbers.push_back(id.number());
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask("SELECT id, version FROM job WHERE id IN (SELECT value FROM json_each(?1))", JsonOf(numbers)));
  std::vector<std::pair<JobId, int64_t>> versions;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return versions;
    versions.emplace_back(JobId(row.Int(0)), row.Int(1));
  }
}

absl::StatusOr<JobQueue> CountJobs(Connection& connection) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT (SELECT count(*) FROM job WHERE state = 1), "
                                                 "(SELECT count(*) FROM job WHERE state = 2), "
                                                 "(SELECT created_at_utc_us FROM job WHERE id = "
                                                 "(SELECT min(id) FROM job WHERE state = 1))"));
  RETURN_IF_ERROR(row.Step().status());
  JobQueue queue{row.Int(0), row.Int(1), {}};
  if (!row.IsNull(2)) queue.oldest_queued = base::FromUtcUs(row.Int(2));
  return queue;
}

absl::StatusOr<JobRecord> HeartbeatJob(Connection& connection, const JobOwner& owner, const JobClaim& claim,
                                       std::chrono::microseconds lease, const JobProgress& progress) {
  ASSIGN_OR_RETURN(const JobRecord job, CheckClaim(connection, owner, claim));
  RETURN_IF_ERROR(
      connection.Run("UPDATE job SET lease_until_steady_us = ?2, progress_stage = ?3, progress_fraction = ?4, "
                     "progress_detail = ?5, version = version + ?6 WHERE id = ?1",
                     claim.id, LeaseEndUs(owner, lease), progress.stage, progress.fraction, progress.detail,
                     progress == job.progress ? 0 : 1));
  return GetJob(connection, claim.id);
}

absl::StatusOr<JobRecord> SucceedJob(Connection& connection, const JobOwner& owner, const JobClaim& claim,
                                     const JobProduct& product) {
  ASSIGN_OR_RETURN(const JobRecord job, CheckClaim(connection, owner, claim));
  RETURN_IF_ERROR(CheckCreator(connection, job));
  if (product.calibration.has_value()) {
    RETURN_IF_ERROR(CreateCalibration(connection, owner.now.utc, *product.calibration, claim.id).status());
  }
  RETURN_IF_ERROR(InsertPrograms(connection, claim.id, product.programs));
  RETURN_IF_ERROR(connection.Run(
      "UPDATE job SET state = 3, owner = NULL, lease_until_steady_us = NULL, result = ?2, progress_fraction = 1.0, "
      "error_code = NULL, "
      "error_reason = NULL, error_message = NULL, ended_at_utc_us = ?3, version = version + 1, result_sha256 = ?4 "
      "WHERE id = ?1",
      claim.id, Blob{product.result}, owner.now.utc, JobResultChecksum(claim.id, product.result)));
  RETURN_IF_ERROR(EndAttempt(connection, owner.now.utc, claim.id, claim.lease_token, "SUCCEEDED", ""));
  return GetJob(connection, claim.id);
}

absl::StatusOr<JobRecord> EndJob(Connection& connection, const JobOwner& owner, const JobClaim& claim, JobEnd end,
                                 const JobError& error, std::chrono::microseconds retry_after) {
  ASSIGN_OR_RETURN(const JobRecord job, CheckClaim(connection, owner, claim));
  RETURN_IF_ERROR(Leave(connection, owner.now, job, end, Name(end), error, retry_after));
  return GetJob(connection, claim.id);
}

absl::StatusOr<std::vector<JobRecord>> RescueJobs(Connection& connection, const JobOwner& owner) {
  std::vector<std::pair<JobId, std::string>> lost;
  {
    ASSIGN_OR_RETURN(
        Statement row,
        owner.is_alone
            ? connection.Ask("SELECT id, owner FROM job WHERE state = 2 AND (owner <> ?1 OR lease_until_steady_us < "
                             "?2) ORDER BY id",
                             owner.id, owner.lease_now_us)
            : connection.Ask("SELECT id, owner FROM job WHERE state = 2 AND lease_until_steady_us < ?1 ORDER BY id",
                             owner.lease_now_us));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      lost.emplace_back(JobId(row.Int(0)), row.Text(1));
    }
  }
  std::vector<JobRecord> rescued;
  for (const auto& [id, whose] : lost) {
    ASSIGN_OR_RETURN(const JobRecord job, GetJob(connection, id));
    if (IsOfEarlierBoot(whose, owner.id)) {
      const JobError error = {absl::StatusCode::kUnavailable, "MACHINE_RESTARTED",
                              absl::StrCat("attempt ", job.attempt, " was not finished: the machine was restarted")};
      RETURN_IF_ERROR(Leave(connection, owner.now, job, JobEnd::kParked, "LOST", error, std::chrono::microseconds(0)));
    } else {
      RETURN_IF_ERROR(connection.Run("UPDATE job SET lost = lost + 1 WHERE id = ?1", id));
      ASSIGN_OR_RETURN(const int times, LostOf(connection, id));
      const JobError error = {absl::StatusCode::kUnavailable, "OWNER_LOST", WhyLost(job.attempt, times)};
      RETURN_IF_ERROR(Leave(connection, owner.now, job, JobEnd::kRetry, "LOST", error, WaitAfterLoss(id, times)));
    }
    ASSIGN_OR_RETURN(rescued.emplace_back(), GetJob(connection, id));
  }
  RETURN_IF_ERROR(FailLate(connection, owner.now, rescued));
  return rescued;
}

absl::StatusOr<std::vector<JobRecord>> ReturnJobs(Connection& connection, const JobOwner& owner,
                                                  const std::vector<JobClaim>& held) {
  std::vector<JobId> lost;
  {
    ASSIGN_OR_RETURN(
        Statement row,
        connection.Ask("SELECT id, lease_token FROM job WHERE state = 2 AND owner = ?1 ORDER BY id", owner.id));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      const JobId id(row.Int(0));
      const int64_t token = row.Int(1);
      const bool is_held = std::any_of(held.begin(), held.end(), [&](const JobClaim& claim) {
        return claim.id == id && claim.lease_token == token;
      });
      if (!is_held) lost.push_back(id);
    }
  }
  std::vector<JobRecord> returned;
  for (const JobId id : lost) {
    ASSIGN_OR_RETURN(const JobRecord job, GetJob(connection, id));
    const JobError error = {
        absl::StatusCode::kUnavailable, "STORE_AWAY",
        absl::StrCat("put back: the store went away while attempt ", job.attempt, " began or ended")};
    RETURN_IF_ERROR(Leave(connection, owner.now, job, JobEnd::kParked, "PARKED", error, std::chrono::microseconds(0)));
    ASSIGN_OR_RETURN(returned.emplace_back(), GetJob(connection, id));
  }
  return returned;
}

}  // namespace axiscal::storage
