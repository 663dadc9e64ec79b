// The store on a PostgreSQL server, which several hosts can reach and which has its own standbys. Several processes may
// have one database open: docs/scale.md says how they go together.
#ifndef AXISCAL_SERVER_STORAGE_POSTGRES_DATABASE_H_
#define AXISCAL_SERVER_STORAGE_POSTGRES_DATABASE_H_

#include <functional>
#include <memory>
#include <string>

#include "core/base/clock.h"
#include "server/storage/database.h"

namespace axiscal::storage {

struct PostgresOptions {
  // Server and database as libpq takes them: "postgresql://user@host:5432/axiscal". The database is there and keeps
  // texts as UTF-8; the user may make tables in it.
  std::string url;
  // Told on open, for each job that a process left RUNNING when it died, what became of it; of other processes that
  // have the store, RescueJobs() does. May be empty.
  std::function<void(const JobRecord&)> rescued;
  // As SqliteOptions::damaged. May be empty.
  std::function<void(const absl::Status&)> damaged;
  base::Clock* clock = &base::SystemClock();
};

// Connects, brings the tables to this program's schema, and, where no other process has the store, returns RUNNING jobs
// of one that died to the queue; others wait meanwhile.
//   no server, or it refuses: UNAVAILABLE STORE_DOWN; held by a process that copies it, or that has opened it alone and
//   brings it up to date for longer than half a minute: UNAVAILABLE STORE_LOCKED; not ours, or
//   of a newer version: FAILED_PRECONDITION NOT_A_DATABASE, SCHEMA_NEWER, SCHEMA_CHANGED.
// A server that goes away meanwhile is connected to again by the next call. A write under way then returns UNAVAILABLE
// STORE_DOWN; it may have been committed. Each connection that is new looks whether this program may still run on the
// tables: where others have brought them to a version that does not allow it, all calls return FAILED_PRECONDITION
// SCHEMA_NEWER; where an older backup was put in their place, SCHEMA_OLDER.
// No call may be under way when it is destroyed.
absl::StatusOr<std::unique_ptr<Database>> OpenPostgres(const PostgresOptions& options);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_POSTGRES_DATABASE_H_
