#include "server/handlers/query_drift.h"

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "core/base/error_detail.h"
#include "proto/convert/history.h"
#include "server/storage/page_token.h"

namespace axiscal::handlers {
namespace {

// Behind which point a page begins.
struct DriftPlace {
  std::string symbol;
  int64_t last_utc_us = 0;
};

absl::StatusOr<std::optional<DriftPlace>> PlaceOf(const storage::PageStart& start) {
  if (!start.after) return std::nullopt;
  const std::pair<std::string, std::string> parts = absl::StrSplit(*start.after, absl::MaxSplits('|', 1));
  DriftPlace place{parts.second, 0};
  if (!absl::SimpleAtoi(parts.first, &place.last_utc_us)) {
    return base::Error(absl::StatusCode::kInvalidArgument, "page_token: is not one that a list has given",
                       {"PAGE_INVALID", {{"field", "page_token"}}});
  }
  return place;
}

// What is listed: a token holds for no other question.
std::string ListOf(v1::QueryDriftRequest request) {
  request.clear_page_size();
  request.clear_page_token();
  return "drift|" + request.SerializeAsString();
}

}  // namespace

absl::StatusOr<v1::QueryDriftResponse> QueryDrift(Core& core, const Call& call, const v1::QueryDriftRequest& request) {
  ASSIGN_OR_RETURN(const records::DriftQuery query, convert::FromProto(request));
  ASSIGN_OR_RETURN(const storage::PageStart start,
                   storage::StartPage({request.page_size(), request.page_token()}, ListOf(request)));
  ASSIGN_OR_RETURN(const std::optional<DriftPlace> after, PlaceOf(start));
  ASSIGN_OR_RETURN(const std::vector<records::DriftSeries> all, core.database.QueryDrift(query));
  v1::QueryDriftResponse response;
  int left = request.page_size() == 0 ? std::numeric_limits<int>::max() : request.page_size();
  std::string last;
  for (const records::DriftSeries& series : all) {
    if (after && series.symbol < after->symbol) continue;
    v1::DriftSeries message = convert::ToProto(series);
    auto& points = *message.mutable_points();
    int first = 0;
    while (after && series.symbol == after->symbol && first < points.size() &&
           points[first].last_utc_us() <= after->last_utc_us)
      ++first;
    points.DeleteSubrange(0, first);
    if (after && points.empty()) continue;
    if (left == 0 && !points.empty()) {
      response.set_next_page_token(storage::MakePageToken(start, last));
      break;
    }
    if (points.size() > left) points.DeleteSubrange(left, points.size() - left);
    const bool is_cut = first + points.size() < static_cast<int>(series.points.size());
    left -= points.size();
    if (!points.empty()) last = absl::StrCat(points[points.size() - 1].last_utc_us(), "|", series.symbol);
    *response.add_series() = std::move(message);
    if (is_cut) {
      response.set_next_page_token(storage::MakePageToken(start, last));
      break;
    }
  }
  return response;
}

}  // namespace axiscal::handlers
