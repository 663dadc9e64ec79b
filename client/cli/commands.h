// One function per sub-command; each adds it to the command line with its options, help and examples.
#ifndef AXISCAL_CLIENT_CLI_COMMANDS_H_
#define AXISCAL_CLIENT_CLI_COMMANDS_H_

namespace CLI {
class App;
}

namespace axiscal::cli {

struct Context;

void AddMachineCommand(CLI::App& app, Context& context);
void AddReduceCommand(CLI::App& app, Context& context);
void AddUploadCommand(CLI::App& app, Context& context);
void AddSpoolCommand(CLI::App& app, Context& context);
void AddCellsCommand(CLI::App& app, Context& context);
void AddDoctorCommand(CLI::App& app, Context& context);
void AddSessionCommand(CLI::App& app, Context& context);
void AddIdentifyCommand(CLI::App& app, Context& context);
void AddApproveCommand(CLI::App& app, Context& context);
void AddCalibrationCommand(CLI::App& app, Context& context);
void AddCloseLoopCommand(CLI::App& app, Context& context);
void AddCompensateCommand(CLI::App& app, Context& context);
void AddVerifyCommand(CLI::App& app, Context& context);
void AddPredictCommand(CLI::App& app, Context& context);
void AddCompareCommand(CLI::App& app, Context& context);
void AddReportCommand(CLI::App& app, Context& context);
void AddFiguresCommand(CLI::App& app, Context& context);
void AddTableCommand(CLI::App& app, Context& context);
void AddProgramCommand(CLI::App& app, Context& context);
void AddPlanCommand(CLI::App& app, Context& context);
void AddSimulateCommand(CLI::App& app, Context& context);
void AddToolSetterCommand(CLI::App& app, Context& context);
void AddPublishedCommand(CLI::App& app, Context& context);
void AddDriftCommand(CLI::App& app, Context& context);
void AddVolumetricCommand(CLI::App& app, Context& context);
void AddExpectCommand(CLI::App& app, Context& context);
void AddEventsCommand(CLI::App& app, Context& context);
void AddRoutineCommand(CLI::App& app, Context& context);
void AddWebhookCommands(CLI::App* admin, Context& context);
void AddMarkCommand(CLI::App& app, Context& context);
void AddCareCommand(CLI::App& app, Context& context);
void AddHistoryCommand(CLI::App& app, Context& context);
void AddJobsCommand(CLI::App& app, Context& context);
void AddBackupCommand(CLI::App& app, Context& context);
void AddAdminCommand(CLI::App& app, Context& context);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_COMMANDS_H_
