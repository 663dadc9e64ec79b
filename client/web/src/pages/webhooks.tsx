// Addresses that are told of events: how each stands, what could not be brought there, a test. For admins of all machines.
import { create } from "@bufbuild/protobuf";
import { useState } from "preact/hooks";
import { epoch, problemOf, useLoad, type Problem } from "../api";
import { countText, timeText } from "../format";
import { WebhookSchema, type Webhook } from "../gen/axiscal/v1/webhooks_service_pb";
import { Asking, Empty, Fact, FormDialog, ProblemBox, Quoted, Server, Show, Table, Title, fieldOf } from "../parts";
import { webhooks } from "../services";
import { isAdminOfAll } from "../session";
import { t } from "../text";
import { ScopeFields, scopeFrom, scopeText } from "./routines";

const kEveryMs = 5000;

function Edit(props: { webhook?: Webhook; onClose: () => void; onSecret: (secret: string) => void }) {
  const { webhook } = props;
  const save = async (form: FormData) => {
    const answer = await webhooks.putWebhook({
      etag: webhook?.etag ?? 0n,
      newSecret: form.get("secret") !== null,
      webhook: create(WebhookSchema, {
        name: webhook?.name ?? fieldOf(form, "name"),
        url: fieldOf(form, "url"),
        scope: scopeFrom(form),
        disabled: form.get("disabled") !== null,
        note: fieldOf(form, "note"),
      }),
    });
    props.onSecret(answer.secret);
    epoch.value++;
  };
  return (
    <FormDialog
      title={webhook ? t("webhookChange", { name: webhook.name }) : t("webhookNew")}
      submit={t("save")}
      intro={<p>{t("webhookHelp")}</p>}
      onSend={save}
      onClose={props.onClose}
    >
      {!webhook && (
        <label>
          {t("name")}
          <input name="name" required autocomplete="off" />
        </label>
      )}
      <label>
        {t("address")}
        <input name="url" type="url" required autocomplete="off" defaultValue={webhook?.url} />
      </label>
      <ScopeFields scope={webhook?.scope} mayBeAll />
      <label>
        {t("note")}
        <input name="note" autocomplete="off" defaultValue={webhook?.note} />
      </label>
      <label class="check">
        <input name="disabled" type="checkbox" defaultChecked={webhook?.disabled} /> {t("webhookDisabled")}
      </label>
      {webhook && (
        <label class="check">
          <input name="secret" type="checkbox" /> {t("newSecret")}
        </label>
      )}
    </FormDialog>
  );
}

function DeadLetters(props: { name: string }) {
  const found = useLoad(`dead ${props.name}`, () => webhooks.listDeadLetters({ name: props.name, pageSize: 50 }));
  return (
    <Show of={found} rows={3}>
      {(page) => (
        <Table label={`${t("deadLetters")}: ${props.name}`} head={[t("event"), t("machine"), t("tries"), t("why"), t("time")]} numbers={[2]}>
          {page.letters.map((letter) => (
            <tr>
              <th scope="row">{String(letter.eventId)}</th>
              <td>
                <a href={`#/events/${encodeURIComponent(letter.machineId)}`}>{letter.machineId}</a>
              </td>
              <td class="number">{countText(letter.tries)}</td>
              <td class="text">
                <Server text={letter.error} />
              </td>
              <td>{timeText(letter.triedUtcUs)}</td>
            </tr>
          ))}
        </Table>
      )}
    </Show>
  );
}

function WebhookBox(props: { webhook: Webhook; onSecret: (secret: string) => void }) {
  const { webhook } = props;
  const [isEdited, setEdited] = useState(false);
  const [isOpen, setOpen] = useState(false);
  const [problem, setProblem] = useState<Problem>();
  const [answer, setAnswer] = useState<{ said: string; error: string }>();
  const act = async (what: () => Promise<unknown>) => {
    try {
      setProblem(undefined);
      await what();
      epoch.value++;
    } catch (error) {
      setProblem(problemOf(error));
    }
  };
  const test = async () => {
    setAnswer(undefined);
    const came = await webhooks.testWebhook({ name: webhook.name });
    const taken = t("testTaken", { by: came.isMail ? "SMTP" : "HTTP", n: came.httpStatus, ms: countText(came.tookMs) });
    setAnswer({ said: came.error === "" ? taken : t("testNotTaken"), error: came.error });
  };
  return (
    <article class="box">
      <h2>
        {webhook.name}{" "}
        {webhook.disabled ? (
          <span class="mark old">{t("isDisabled")}</span>
        ) : webhook.lastError ? (
          <span class="mark bad">{t("webhookFails")}</span>
        ) : (
          webhook.lastSentUtcUs !== undefined && <span class="mark good">{t("webhookStands")}</span>
        )}
      </h2>
      {webhook.note && <p>{webhook.note}</p>}
      <dl class="facts">
        <Fact name={t("address")}>
          <code>{webhook.url}</code>
        </Fact>
        <Fact name={t("forWhat")}>{scopeText(webhook.scope)}</Fact>
        <Fact name={t("lastSent")}>{webhook.lastSentUtcUs === undefined ? t("never") : timeText(webhook.lastSentUtcUs)}</Fact>
        <Fact name={t("deadLetters")}>{countText(webhook.deadLetters)}</Fact>
        {webhook.nextTryUtcUs !== undefined && (
          <Fact name={t("nextTry")}>
            {timeText(webhook.nextTryUtcUs)}, {t("triesSoFar", { n: countText(webhook.tries) })}
          </Fact>
        )}
      </dl>
      {webhook.lastError && (
        <p>
          <Quoted said={t("webhookLastError")} text={webhook.lastError} />
        </p>
      )}
      {problem && <ProblemBox problem={problem} />}
      <p role="status">{answer && <Quoted said={answer.said} text={answer.error} />}</p>
      <p class="buttons">
        <button type="button" class="quiet" aria-label={`${t("test")}: ${webhook.name}`} onClick={() => void act(test)}>
          {t("test")}
        </button>
        {webhook.deadLetters > 0n && (
          <>
            <button type="button" class="quiet" aria-expanded={isOpen} aria-label={`${t("deadLetters")}: ${webhook.name}`} onClick={() => setOpen(!isOpen)}>
              {t("deadLetters")}
            </button>
            <button
              type="button"
              class="quiet"
              aria-label={`${t("resend")}: ${webhook.name}`}
              onClick={() => void act(() => webhooks.resendDeadLetters({ name: webhook.name }))}
            >
              {t("resend")}
            </button>
          </>
        )}
        <button type="button" class="quiet" aria-label={`${t("change")}: ${webhook.name}`} onClick={() => setEdited(true)}>
          {t("change")}
        </button>
        <Asking
          text={t("remove")}
          of={webhook.name}
          effect={t("webhookRemoveEffect")}
          onSure={async () => {
            await webhooks.removeWebhook({ name: webhook.name, etag: webhook.etag });
            epoch.value++;
          }}
        />
      </p>
      {isOpen && <DeadLetters name={webhook.name} />}
      {isEdited && <Edit webhook={webhook} onClose={() => setEdited(false)} onSecret={props.onSecret} />}
    </article>
  );
}

export function WebhooksPage() {
  const [isNew, setNew] = useState(false);
  const [secret, setSecret] = useState("");
  const mayUse = isAdminOfAll();
  const found = useLoad(`webhooks ${mayUse}`, async () => (mayUse ? (await webhooks.listWebhooks({})).webhooks : []), kEveryMs);
  if (!mayUse) {
    return (
      <>
        <Title text={t("webhooksTitle")} />
        <p>{t("adminOnlyWebhooks")}</p>
      </>
    );
  }
  return (
    <>
      <Title text={t("webhooksTitle")} />
      <p>{t("webhooksHelp")}</p>
      <p class="buttons">
        <button type="button" onClick={() => setNew(true)}>
          {t("webhookNew")}
        </button>
      </p>
      {secret && (
        <p class="box" role="status">
          {t("secretOnce")} <code>{secret}</code>
        </p>
      )}
      <Show of={found} rows={5}>
        {(list) =>
          list.length === 0 ? (
            <Empty text={t("webhooksNone")} first={t("webhooksFirst")} />
          ) : (
            <>
              {list.map((one) => (
                <WebhookBox key={one.name} webhook={one} onSecret={setSecret} />
              ))}
            </>
          )
        }
      </Show>
      {isNew && <Edit onClose={() => setNew(false)} onSecret={setSecret} />}
    </>
  );
}
