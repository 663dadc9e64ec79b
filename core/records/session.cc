#include "core/records/session.h"

namespace axiscal::records {

SessionSchema SchemaOf(const session::Session& session) {
  SessionSchema schema{session.header, {}};
  for (const session::Column& column : session.columns) schema.columns.push_back({column.name, !column.texts.empty()});
  return schema;
}

}  // namespace axiscal::records
