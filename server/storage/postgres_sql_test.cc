#include "server/storage/postgres_sql.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace axiscal::storage {
namespace {

using ::testing::ElementsAre;

TEST(PostgresSqlTexts, ParametersAreNumberedAsTheTextUsesThem) {
  const PostgresSql sql = ToPostgres("SELECT id FROM job WHERE id < ?4 AND (state = ?2 OR id = ?4) LIMIT ?11");
  EXPECT_EQ(sql.text, "SELECT id FROM job WHERE id < $1 AND (state = $2 OR id = $1) LIMIT $3");
  EXPECT_THAT(sql.parameters, ElementsAre(4, 2, 11));
}

TEST(PostgresSqlTexts, HintsGo) {
  EXPECT_EQ(ToPostgres("SELECT id FROM job INDEXED BY job_at WHERE +kind = ?1 AND a + b > 1").text,
            "SELECT id FROM job  WHERE kind = $1 AND a + b > 1");
  EXPECT_EQ(ToPostgres("FROM cell AS c CROSS JOIN machine AS m ON m.id = c.machine_id").text,
            "FROM cell AS c JOIN machine AS m ON m.id = c.machine_id");
}

TEST(PostgresSqlTexts, AListOfNumbersIsATable) {
  EXPECT_EQ(ToPostgres("WHERE id IN (SELECT value FROM json_each(?5)) AND x = ?1").text,
            "WHERE id IN (SELECT value FROM (SELECT CAST(jsonb_array_elements_text(CAST($1 AS jsonb)) AS BIGINT) AS "
            "value) AS json_each) AND x = $2");
}

TEST(PostgresSqlTexts, WhatIsForSeveralWritersAlone) {
  EXPECT_EQ(ToPostgres("SELECT count(*) / 2 FROM job WHERE id = ?3 LIMIT 1 /*! FOR UPDATE SKIP LOCKED */").text,
            "SELECT count(*) / 2 FROM job WHERE id = $1 LIMIT 1  FOR UPDATE SKIP LOCKED ");
}

TEST(PostgresSqlTexts, WhatStandsInQuotesStays) {
  EXPECT_EQ(ToPostgres("SELECT 'is it ?1 +x, ''CROSS JOIN''?', \"+y\" WHERE a = ?1").text,
            "SELECT 'is it ?1 +x, ''CROSS JOIN''?', \"+y\" WHERE a = $1");
}

}  // namespace
}  // namespace axiscal::storage
