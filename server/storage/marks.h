// Marks of people in the histories of machines. A mark is never changed; one that was a mistake is withdrawn and stays.
#ifndef AXISCAL_SERVER_STORAGE_MARKS_H_
#define AXISCAL_SERVER_STORAGE_MARKS_H_

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// As Database has them.
absl::StatusOr<Mark> PutMark(Connection& connection, UtcTime now, const NewMark& mark, const Caller& caller);
absl::StatusOr<Mark> GetMark(Connection& connection, MarkId id);
absl::StatusOr<Mark> WithdrawMark(Connection& connection, UtcTime now, MarkId id, const Caller& caller);
absl::StatusOr<Page<Mark>> ListMarks(Connection& connection, const MachineId& machine, const PageRequest& request);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_MARKS_H_
