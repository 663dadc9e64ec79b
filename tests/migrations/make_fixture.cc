// Writes the file that a released schema's dump is made of (migrations/README.md): make_migration_fixture FILE.
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

void MakeFixture(const std::string& path) {
  base::FakeClock clock;
  SqliteOptions options;
  options.path = path;
  options.clock = &clock;
  const std::unique_ptr<Database> database = *OpenSqlite(options);
  const SessionId session = StoreSession(*database, 3);
  DEMAND(database->UpdateMachine(MachineId("mt"), 1, "{\"id\":\"mt\"}", Cell("")).ok());
  const SessionId open = database->CreateSession(TestSession("open"))->id;
  DEMAND(Append(*database, open, 0, TestColumns(0, 10)).ok());

  const ProgramId program = database->BeginProgram({"nc", "O1.nc", Cell("p")})->id;
  DEMAND(database->AppendProgram(program, 0, "G01 X1\n").ok());
  DEMAND(database->FinishProgram(program, 7, "").ok());

  NewJob job;
  job.kind = "identify";
  job.machine = MachineId("mt");
  for (const char* request_id : {"j1", "j2"}) {
    job.caller = Cell(request_id);
    DEMAND(database->CreateJob(job, 10).ok());
  }
  const JobRecord claimed = **database->ClaimJob(std::chrono::seconds(30));
  JobProduct product = {"result", TestCalibration(clock.UtcNow(), -101.2), {program}};
  product.calibration->sessions = {session};
  const JobRecord done = *database->SucceedJob(ClaimOf(claimed), product);
  clock.Advance(std::chrono::hours(24));
  DEMAND(database->CreateCalibration(TestCalibration(clock.UtcNow(), -90.0)).ok());
  DEMAND(database->ApproveCalibration(*done.calibration, 0, Cell("")).ok());
  DEMAND((*database->ClaimJob(std::chrono::seconds(30))).has_value());  // left RUNNING
}

}  // namespace
}  // namespace axiscal::storage

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  axiscal::storage::MakeFixture(argv[1]);
  return 0;
}
