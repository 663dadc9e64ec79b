// The audit, newest first, for admins of all machines.
import { useState } from "preact/hooks";
import { access, problemOf, useLoad, type Problem } from "../api";
import { timeText } from "../format";
import { Empty, ProblemBox, Show, Table, Title } from "../parts";
import { isAdminOfAll } from "../session";
import { t, tMaybe } from "../text";

// "calibration.approve", "denied Calibrations/ApproveCalibration": in words, where the page knows it.
const actionText = (action: string) => tMaybe(`action_${action.split(" ")[0]}`) ?? "";

export function AuditPage() {
  const [asked, setAsked] = useState({ principal: "", resource: "" });
  const [most, setMost] = useState(50);
  const [chain, setChain] = useState<{ text?: string; problem?: Problem }>({});
  const found = useLoad(`audit ${JSON.stringify(asked)} ${most}`, async () =>
    isAdminOfAll() ? await access.listAudit({ ...asked, pageSize: most }) : undefined,
  );
  if (!isAdminOfAll()) {
    return (
      <>
        <Title text={t("auditTitle")} />
        <p class="muted">{t("adminOnly")}</p>
      </>
    );
  }
  const check = async () => {
    try {
      const answer = await access.checkAudit({});
      setChain({ text: t("chainWhole", { n: answer.lastEntryNumber, hash: answer.sha256 }) });
    } catch (error) {
      setChain({ problem: problemOf(error) });
    }
  };
  return (
    <>
      <Title text={t("auditTitle")} />
      <form
        class="filters"
        onSubmit={(event) => {
          event.preventDefault();
          const form = new FormData(event.currentTarget as HTMLFormElement);
          setAsked({ principal: String(form.get("who")).trim(), resource: String(form.get("what")).trim() });
        }}
      >
        <label>
          {t("ofWhom")}
          <input name="who" autocomplete="off" />
        </label>
        <label>
          {t("ofWhat")}
          <input name="what" autocomplete="off" />
        </label>
        <button type="submit">{t("refresh")}</button>
        <button type="button" class="quiet" onClick={() => void check()}>
          {t("checkChain")}
        </button>
      </form>
      <div role="status">{chain.text && <p class="box good break">{chain.text}</p>}</div>
      {chain.problem && <ProblemBox problem={chain.problem} />}
      <Show of={found} rows={8}>
        {(page) =>
          page === undefined || page.entries.length === 0 ? (
            <Empty text={t("auditNone")} />
          ) : (
            <>
              <p class="muted">{t("auditWords")}</p>
              <Table label={t("auditTitle")} head={["#", t("time"), t("who"), t("action"), t("resource"), t("was"), t("became"), t("detail")]} numbers={[0]}>
                {page.entries.map((entry) => (
                  <tr key={String(entry.entryNumber)}>
                    <td class="number">{String(entry.entryNumber)}</td>
                    <td>{timeText(entry.atUtcUs)}</td>
                    <td>
                      {entry.principal || "–"}
                      <br />
                      <small>{entry.peer}</small>
                    </td>
                    <td>
                      {actionText(entry.action)} {entry.outcome !== "OK" && <span class="mark bad" lang="en">{entry.outcome}</span>}
                      <br />
                      <small lang="en">{entry.action}</small>
                    </td>
                    <td class="text" lang="en">{entry.resource}</td>
                    <td class="text" lang="en">{entry.was.slice(0, 200)}</td>
                    <td class="text" lang="en">{entry.became.slice(0, 200)}</td>
                    <td class="text" lang="en">{entry.detail}</td>
                  </tr>
                ))}
              </Table>
              {page.nextPageToken !== "" && (
                <p class="buttons">
                  <button type="button" class="quiet" onClick={() => setMost(most + 100)}>
                    {t("more")}
                  </button>
                </p>
              )}
            </>
          )
        }
      </Show>
    </>
  );
}
