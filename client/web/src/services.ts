// Services that the fleet's page does not need: what describes them to the browser is most of what there is to read, so it comes after.
import { create, toJsonString } from "@bufbuild/protobuf";
import { createClient } from "@connectrpc/connect";
import { transport } from "./api";
import { Calibrations } from "./gen/axiscal/v1/calibrations_service_pb";
import { JobParamsSchema, type JobParams } from "./gen/axiscal/v1/job_pb";
import { Jobs } from "./gen/axiscal/v1/jobs_service_pb";
import { Machines } from "./gen/axiscal/v1/machines_service_pb";
import { Programs } from "./gen/axiscal/v1/programs_service_pb";
import { Routines } from "./gen/axiscal/v1/routines_service_pb";
import { Tables } from "./gen/axiscal/v1/tables_service_pb";
import { Webhooks } from "./gen/axiscal/v1/webhooks_service_pb";

export const calibrations = createClient(Calibrations, transport);
export const jobs = createClient(Jobs, transport);
export const machines = createClient(Machines, transport);
export const programs = createClient(Programs, transport);
export const routines = createClient(Routines, transport);
export const tables = createClient(Tables, transport);
export const webhooks = createClient(Webhooks, transport);

// Queues a job and returns its number. Asked again after an answer that was lost, the same job is meant.
const asked = new Map<string, string>();
export async function createJob(kind: JobParams["kind"], priority = 0): Promise<bigint> {
  const params = create(JobParamsSchema, { kind });
  const key = `${priority} ${toJsonString(JobParamsSchema, params)}`;
  const requestId = asked.get(key) ?? crypto.randomUUID();
  asked.set(key, requestId);
  const { job } = await jobs.createJob({ requestId, params, priority });
  asked.delete(key);
  return job!.jobId;
}
