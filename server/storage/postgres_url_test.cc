#include "server/storage/postgres_url.h"

#include <gtest/gtest.h>

namespace axiscal::storage {
namespace {

TEST(PostgresUrl, IsNoFile) {
  EXPECT_TRUE(IsPostgresUrl("postgresql://db.shop/axiscal"));
  EXPECT_TRUE(IsPostgresUrl("postgres:///axiscal"));
  EXPECT_FALSE(IsPostgresUrl("/var/lib/axiscal/axiscal.db"));
  EXPECT_FALSE(IsPostgresUrl("postgresql.db"));
}

TEST(PostgresUrl, IsShownWithoutItsPassword) {
  EXPECT_EQ(WithoutPassword("postgresql://ann:se@cret@db.shop:5432/axiscal?sslmode=require"),
            "postgresql://ann:***@db.shop:5432/axiscal?sslmode=require");
  EXPECT_EQ(WithoutPassword("postgresql://ann@db.shop/axiscal?password=secret&sslmode=require&sslpassword=other"),
            "postgresql://ann@db.shop/axiscal?password=***&sslmode=require&sslpassword=***");
  EXPECT_EQ(WithoutPassword("postgresql://db.shop:5432/axiscal"), "postgresql://db.shop:5432/axiscal");
  EXPECT_EQ(WithoutPassword("postgresql:///axiscal?host=/run/a@b:c"), "postgresql:///axiscal?host=/run/a@b:c");
  EXPECT_EQ(WithoutPassword("/var/a:b@c.db"), "/var/a:b@c.db");
}

}  // namespace
}  // namespace axiscal::storage
