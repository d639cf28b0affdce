import { Paper, Text, Title } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { CircleCheck, CircleMinus, CircleX, LoaderCircle } from "lucide-react";
import type { ReactNode } from "react";
import { connection } from "@/api/connection";
import { infoQuery, kindsQuery, readinessQuery, usageQuery } from "@/api/queries";
import type { JobState, Usage } from "@/api/types";
import { LinkAnchor } from "@/app/links";
import { useStore } from "@/app/store";
import { bytes, capital, integer } from "@/format/format";
import classes from "./home.module.css";

const PARTS: Record<string, string> = { database: "Database", queue: "Queue", storage: "Storage" };
const KINDS: Record<string, [string, string]> = {
  volume: ["volume", "volumes"],
  mesh: ["mesh", "meshes"],
  sequence: ["sequence", "sequences"],
  motion: ["motion", "motions"],
};

/** How the server is: what it stands on, who works, what waits, what is kept. */
export function ServerState() {
  const info = useQuery(infoQuery);
  const readiness = useQuery(readinessQuery);
  const kinds = useQuery({ ...kindsQuery, refetchInterval: 10_000 });
  const usage = useQuery(usageQuery);
  const silent = useStore(connection) === "down";
  const services = new Map(kinds.data?.map(({ service, workers }) => [service, workers]));
  return (
    <Paper p="md" component="section" aria-labelledby="server">
      <Title order={2} id="server">
        This server
      </Title>
      <Text size="xs" c="dimmed" mb="sm">
        {info.data ? `Shapery ${info.data.version}` : " "}
      </Text>
      <div className={classes.parts}>
        <div>
          <Title order={3} mb={4}>
            Parts
          </Title>
          <ul className={classes.states}>
            {silent ? (
              <State is="bad" name="Server">
                does not answer
              </State>
            ) : (
              Object.entries(readiness.data?.checks ?? {}).map(([name, check]) => (
                <State key={name} is={check.status === "ok" ? "good" : "bad"} name={PARTS[name] ?? name}>
                  {check.status === "ok" ? "answers" : check.detail || "does not answer"}
                </State>
              ))
            )}
            {readiness.isError && !readiness.data && !silent && (
              <State is="bad" name="Server">
                does not say how it is
              </State>
            )}
          </ul>
        </div>
        {services.size > 0 && (
          <div>
            <Title order={3} mb={4}>
              Workers
            </Title>
            <ul className={classes.states} data-testid="workers">
              {[...services].map(([service, workers]) => (
                <State key={service} is={workers > 0 ? "good" : "none"} name={capital(service)}>
                  {workers === 0 ? "none" : workers === 1 ? "1 worker" : `${workers} workers`}
                </State>
              ))}
            </ul>
          </div>
        )}
        {usage.data && <Own usage={usage.data} />}
      </div>
    </Paper>
  );
}

/** What the queue and the storage hold of whoever looks. */
function Own({ usage }: { usage: Usage }) {
  const running = count(usage, "running", "cancelling");
  const failed = count(usage, "failed", "crashed");
  return (
    <>
      <div>
        <Title order={3} mb={4}>
          Your jobs
        </Title>
        <ul className={classes.states}>
          <State is={running > 0 ? "busy" : "none"} name="Running">
            {integer(running)}
          </State>
          <State is="none" name="Waiting">
            {integer(count(usage, "queued"))}
          </State>
          {failed > 0 && (
            <State
              is="bad"
              name={
                <LinkAnchor to="/jobs" search={{ state: "failed" }} size="sm" c="inherit" underline="always">
                  Failed
                </LinkAnchor>
              }
            >
              {integer(failed)}
            </State>
          )}
        </ul>
      </div>
      <div>
        <Title order={3} mb={4}>
          Kept for you
        </Title>
        <dl className={classes.kept} data-testid="kept">
          {Object.entries(usage.assets).map(([kind, stored]) => (
            <div key={kind}>
              <dt>
                {integer(stored.files)} {KINDS[kind]?.[stored.files === 1 ? 0 : 1] ?? kind}
              </dt>
              <dd>{bytes(stored.bytes)}</dd>
            </div>
          ))}
          <div>
            <dt>
              {integer(usage.results.files)} result {usage.results.files === 1 ? "file" : "files"}
            </dt>
            <dd>{bytes(usage.results.bytes)}</dd>
          </div>
        </dl>
      </div>
    </>
  );
}

function count({ jobs }: Usage, ...states: JobState[]): number {
  return states.reduce((sum, state) => sum + (jobs[state] ?? 0), 0);
}

const ICONS = { good: CircleCheck, bad: CircleX, none: CircleMinus, busy: LoaderCircle };

function State({ is, name, children }: { is: keyof typeof ICONS; name: ReactNode; children: ReactNode }) {
  const Icon = ICONS[is];
  return (
    <li data-is={is}>
      <Icon size={15} aria-hidden="true" />
      <span>{name}</span>
      <span>{children}</span>
    </li>
  );
}
