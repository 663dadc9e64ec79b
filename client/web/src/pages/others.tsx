// Every page but the fleet's.
import { Title } from "../parts";
import { t } from "../text";
import { AuditPage } from "./audit";
import { CalibrationPage } from "./calibration";
import { CellsPage } from "./cells";
import { EventsPage } from "./events";
import { JobPage, JobsPage } from "./jobs";
import { LoopPage } from "./loop";
import { MachinePage } from "./machine";
import { ProgramsPage } from "./programs";
import { RoutinesPage } from "./routines";
import { UploadPage } from "./upload";
import { WallPage } from "./wall";
import { WebhooksPage } from "./webhooks";

function idOf(word: string | undefined): bigint | undefined {
  return word !== undefined && /^[1-9]\d{0,17}$/.test(word) ? BigInt(word) : undefined;
}

// "#/machines/mill-7": room "machines", word "mill-7".
export function OtherPage(props: { room: string; word?: string }) {
  const { room, word } = props;
  const id = idOf(word);
  switch (room) {
    case "machines":
      if (word) return <MachinePage key={word} machineId={word} />;
      break;
    case "calibrations":
      if (id) return <CalibrationPage key={word} id={id} />;
      break;
    case "loops":
      if (id) return <LoopPage key={word} id={id} />;
      break;
    case "events":
      return <EventsPage key={word ?? ""} machineId={word} />;
    case "jobs":
      if (id) return <JobPage key={word} id={id} />;
      if (word === undefined) return <JobsPage />;
      break;
    case "programs":
      return <ProgramsPage />;
    case "upload":
      return <UploadPage key={word ?? ""} machineId={word} />;
    case "routines":
      return <RoutinesPage />;
    case "cells":
      return <CellsPage />;
    case "webhooks":
      return <WebhooksPage />;
    case "audit":
      return <AuditPage />;
    case "wall":
      return <WallPage />;
  }
  return (
    <>
      <Title text={t("notFound")} />
      <p>
        <a href="#/">{t("fleet")}</a>
      </p>
    </>
  );
}
