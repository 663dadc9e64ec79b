// Who a claim belongs to: an opening of a store by a process. The text says on which machine and in which of its boots
// that was, so that an attempt which ended with the machine is told from one that ended with its process.
#ifndef AXISCAL_SERVER_STORAGE_JOB_OWNER_H_
#define AXISCAL_SERVER_STORAGE_JOB_OWNER_H_

#include <string>

namespace axiscal::storage {

// 96 random bits (24 digits, hex), then "-MACHINE-BOOT"; without that where the machine does not tell its boot.
std::string NewOwnerId();
// Whether `owner` was on the machine of `self`, which has started again since.
bool IsOfEarlierBoot(const std::string& owner, const std::string& self);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_JOB_OWNER_H_
