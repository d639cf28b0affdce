import { Button, Group, Paper, Progress, Stack, Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { getRouteApi, useNavigate } from "@tanstack/react-router";
import { RotateCw, SearchX } from "lucide-react";
import { useState } from "react";
import { Warnings } from "@/app/Warnings";
import { ApiError } from "@/api/problem";
import { assetQuery } from "@/api/queries";
import { requestOf, searchJobQuery, searchQuery } from "@/api/search";
import { collectionsQuery, shapeQuery } from "@/api/shapes";
import { isTerminal, type Job, type SearchAnswer } from "@/api/types";
import { LinkAnchor, LinkButton } from "@/app/links";
import { Empty, Failure, Waiting } from "@/app/Notice";
import { Page } from "@/app/Page";
import { AsCode } from "@/features/snippets/AsCode";
import { searchSnippets } from "@/features/snippets/snippets";
import { capital, integer, percent } from "@/format/format";
import { HitList } from "./HitList";
import { KeepShape } from "./KeepShape";
import { PairView } from "./PairView";
import { ReindexNotice } from "./ReindexNotice";
import { SearchOptions } from "./SearchOptions";
import { SearchStart } from "./SearchStart";
import { readParts, type SearchAddress, searchOf } from "./searching";
import classes from "./shape.module.css";

const route = getRouteApi("/shapes/search");

export function SearchPage() {
  const address = route.useSearch();
  if (!address.shape && !address.asset) return <SearchStart />;
  return <Searching key={address.shape ?? address.asset} address={address} />;
}

function Searching({ address }: { address: SearchAddress }) {
  const navigate = useNavigate({ from: "/shapes/search" });
  const round = address.round ?? 0;
  const { answer, job, error } = useAnswer(address, round);
  const again = () => void navigate({ search: { ...address, round: round + 1 }, replace: true });
  const shape = useQuery({ ...shapeQuery(address.shape ?? ""), enabled: address.shape !== undefined });
  const asset = useQuery({ ...assetQuery(address.asset ?? ""), enabled: address.asset !== undefined });
  const [asked, setAsked] = useState<string | null>(null);
  const name = shape.data ? shape.data.name || "Without a name" : (asset.data?.filename ?? "…");
  const hits = answer?.hits ?? [];
  const chosen = hits.find((hit) => hit.shape_id === asked) ?? hits[0];
  const parts = readParts(address.parts);
  const made = answer?.job_id ?? null;
  const files = shape.data
    ? { mesh: shape.data.mesh_url, components: shape.data.components_url, version: shape.data.indexed_at }
    : address.asset && made
      ? {
          mesh: `/v1/jobs/${made}/artifacts/mesh.glb`,
          components: `/v1/jobs/${made}/artifacts/components.json`,
          version: "",
        }
      : null;
  return (
    <Page
      tab={`Like ${name}`}
      trail={[
        <LinkAnchor key="shapes" to="/shapes" size="sm">
          Shapes
        </LinkAnchor>,
        <LinkAnchor key="search" to="/shapes/search" search={{}} size="sm">
          Search
        </LinkAnchor>,
      ]}
      title={
        <>
          Like{" "}
          {address.shape ? (
            <LinkAnchor to="/shapes/$shapeId" params={{ shapeId: address.shape }} inherit c="var(--mantine-color-text)">
              {name}
            </LinkAnchor>
          ) : (
            name
          )}
        </>
      }
      lead={
        <span role="status" data-testid="searched">
          {answer
            ? `${integer(hits.length)} found, ${integer(answer.candidates)} compared`
            : error
              ? "The search did not succeed."
              : "Searching…"}
          {parts.length > 0 && ` · by a region of ${parts.length === 1 ? "1 part" : `${parts.length} parts`}`}
        </span>
      }
      actions={
        <Group gap="sm">
          {asset.data && answer && <KeepShape asset={asset.data} />}
          {address.asset && (answer !== null || error !== null) && (
            <Button variant="default" leftSection={<RotateCw size={15} aria-hidden="true" />} onClick={again}>
              Search again
            </Button>
          )}
          <LinkButton to="/shapes/search" search={{}} variant="default">
            Another example
          </LinkButton>
        </Group>
      }
    >
      <Stack gap="md">
        <SearchOptions
          address={address}
          onChange={(change) => void navigate({ search: { ...address, ...change }, replace: true })}
        />
        <Warnings of={answer?.warnings} />
        {error ? (
          shape.data?.outdated ? (
            <ReindexNotice shape={shape.data} />
          ) : (
            <Failure error={error} onRetry={again} />
          )
        ) : !answer ? (
          <Underway job={job} />
        ) : (
          <div className={classes.search}>
            <PairView
              key={made ?? address.shape}
              name={name}
              files={files}
              hit={chosen ?? null}
              parts={parts}
              address={address}
            />
            {hits.length === 0 ? (
              <Paper>
                <Empty icon={<SearchX size={28} />} title="Nothing was found">
                  <NothingFound narrowed={Boolean(address.collection ?? address.labels)} />
                </Empty>
              </Paper>
            ) : (
              <HitList
                hits={hits}
                partial={answer.mode === "partial"}
                chosen={chosen?.shape_id ?? null}
                onChoose={setAsked}
              />
            )}
            <AsCode
              title="This search, as code"
              of={(target) => searchSnippets(requestOf(searchOf(address)), target, asset.data?.filename)}
            />
          </div>
        )}
      </Stack>
    </Page>
  );
}

/** Why a search may have found nothing. */
function NothingFound({ narrowed }: { narrowed: boolean }) {
  const collections = useQuery(collectionsQuery);
  const outdated = collections.data?.reduce((sum, one) => sum + one.outdated, 0) ?? 0;
  return (
    <Text size="sm" c="dimmed">
      {narrowed
        ? "No other shape is in this collection and carries these labels."
        : outdated === 0
          ? "There is no other shape in the bank yet."
          : "No other shape can be compared."}
      {outdated > 0 && (
        <>
          {" "}
          <LinkAnchor to="/shapes" search={{ outdated: true }} size="sm" underline="always">
            {integer(outdated)} indexed by an older version
          </LinkAnchor>{" "}
          can be found once they are indexed again, collection by collection.
        </>
      )}
    </Text>
  );
}

/** The answer of a search, however long it takes. */
function useAnswer(
  address: SearchAddress,
  round: number,
): {
  answer: SearchAnswer | null;
  job: Job | null;
  error: unknown;
} {
  const first = useQuery(searchQuery(searchOf(address), round));
  const begun = first.data && "job" in first.data ? first.data.job : null;
  const later = useQuery({
    ...searchJobQuery(begun?.id ?? ""),
    enabled: begun !== null && !isTerminal(begun.state),
    refetchInterval: ({ state }) =>
      state.error !== null || (state.data && ("answer" in state.data || isTerminal(state.data.job.state)))
        ? false
        : 600,
  });
  const found = begun ? later.data : first.data;
  const answer = found && "answer" in found ? found.answer : null;
  const job = found && "job" in found ? found.job : begun;
  const ended = !answer && job && isTerminal(job.state) ? job : null;
  return {
    answer,
    job,
    error:
      first.error ??
      later.error ??
      (ended &&
        new ApiError(
          500,
          ended.error?.code ?? ended.state,
          ended.error?.message ??
            (ended.expired ? "The results of this search have expired." : "The search was stopped."),
          ended.error?.hint ?? "Search again.",
        )),
  };
}

function Underway({ job }: { job: Job | null }) {
  if (!job) return <Waiting label="Comparing with the bank…" />;
  return (
    <Paper p="lg">
      <Group justify="space-between" mb={6}>
        <Text size="sm" aria-live="polite">
          {job.state === "queued"
            ? "Waiting for a free worker"
            : job.stage === "index"
              ? "Analysing the mesh"
              : capital(job.stage || "working")}
        </Text>
        <Text size="sm" fw={600}>
          {percent(job.fraction)}
        </Text>
      </Group>
      <Progress value={100 * job.fraction} aria-label={`${percent(job.fraction)} done`} transitionDuration={200} />
    </Paper>
  );
}
