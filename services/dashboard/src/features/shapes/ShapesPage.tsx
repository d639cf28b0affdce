import { Button, Group, MultiSelect, Select, Stack, Switch, Text } from "@mantine/core";
import { useInfiniteQuery, useQuery } from "@tanstack/react-query";
import { getRouteApi, useNavigate } from "@tanstack/react-router";
import { ListChecks, Plus, RotateCw, ScanSearch, Search, Shapes, X } from "lucide-react";
import { type DragEvent, useCallback, useState } from "react";
import { collectionsQuery, labelsQuery, shapesQuery, useChangeShapes } from "@/api/shapes";
import type { Collection, ShapeOrder } from "@/api/types";
import { given } from "@/app/given";
import { LinkButton } from "@/app/links";
import { NameFilter } from "@/app/NameFilter";
import { Empty, Failure, Waiting } from "@/app/Notice";
import { Page } from "@/app/Page";
import { say, sayFailure } from "@/app/say";
import { Sure } from "@/app/Sure";
import { droppedFiles, type Picked } from "@/features/uploads/gather";
import { integer } from "@/format/format";
import { Additions } from "./Additions";
import { AddShapes } from "./AddShapes";
import { Collections } from "./Collections";
import classes from "./shapes.module.css";
import { useReindex } from "./useReindex";
import { Wall } from "./Wall";

const route = getRouteApi("/shapes");

const ORDERS: { value: ShapeOrder; label: string }[] = [
  { value: "-created", label: "Newest first" },
  { value: "created", label: "Oldest first" },
  { value: "name", label: "By name" },
  { value: "-name", label: "By name, Z first" },
];

export function ShapesPage() {
  const filter = route.useSearch();
  const navigate = useNavigate({ from: "/shapes" });
  const shapes = useInfiniteQuery(shapesQuery(filter));
  const collections = useQuery(collectionsQuery);
  const labels = useQuery(labelsQuery(filter.collection));
  const [picked, setPicked] = useState<readonly Picked[] | null>(null);
  const [chosen, setChosen] = useState<ReadonlySet<string> | null>(null);
  const [over, setOver] = useState(false);
  const items = shapes.data?.pages.flatMap((page) => page.items) ?? [];
  const all = collections.data ?? [];
  const here = filter.collection === undefined ? all : all.filter(({ name }) => name === filter.collection);
  const outdated = here.reduce((sum, one) => sum + one.outdated, 0);
  const some = items.length > 0 || here.some(({ shapes }) => shapes > 0); // to filter
  const again = useReindex();
  const filtered = Boolean(filter.name ?? filter.labels?.length ?? filter.outdated);
  const { hasNextPage, isFetchingNextPage, fetchNextPage } = shapes;
  const more = useCallback(() => {
    if (!isFetchingNextPage) void fetchNextPage();
  }, [isFetchingNextPage, fetchNextPage]);

  const narrow = (change: Partial<typeof filter>) => {
    setChosen((before) => before && new Set());
    void navigate({ search: (before) => given({ ...before, ...change }), replace: true });
  };
  const choose = useCallback(
    (id: string, on: boolean) =>
      setChosen((before) => {
        const next = new Set(before);
        if (on) next.add(id);
        else next.delete(id);
        return next;
      }),
    [],
  );
  const drop = (event: DragEvent) => {
    if (!event.dataTransfer.types.includes("Files")) return;
    event.preventDefault();
    setOver(false);
    void droppedFiles(event.dataTransfer).then(setPicked);
  };

  return (
    <Page
      title="Shapes"
      tab={filter.collection ?? "Shapes"}
      lead="Meshes that can be found by example: whole or in part, in any pose."
      actions={
        <Group gap="sm">
          <LinkButton to="/shapes/search" variant="default" leftSection={<ScanSearch size={16} aria-hidden="true" />}>
            Search by example
          </LinkButton>
          <Button leftSection={<Plus size={16} aria-hidden="true" />} onClick={() => setPicked([])}>
            Add shapes
          </Button>
        </Group>
      }
    >
      <div
        className={classes.columns}
        data-over={over || undefined}
        onDragOver={(event) => {
          if (!event.dataTransfer.types.includes("Files")) return;
          event.preventDefault();
          setOver(true);
        }}
        onDragLeave={(event) => {
          if (!event.currentTarget.contains(event.relatedTarget as Node | null)) setOver(false);
        }}
        onDrop={drop}
      >
        {over && <div className={classes.drop}>Drop meshes to add them</div>}
        <Collections
          collections={collections.data}
          chosen={filter.collection}
          onChosen={(name) => narrow({ collection: name })}
        />
        <div style={{ minWidth: 0 }}>
          <Additions />
          <div className={classes.filters}>
            {(filtered || some) && <NameFilter name={filter.name} onName={(name) => narrow({ name })} />}
            {((labels.data?.length ?? 0) > 0 || filter.labels) && (
              <MultiSelect
                aria-label="Labels"
                placeholder={filter.labels?.length ? "" : "All labels"}
                data={[
                  ...new Set([
                    ...(labels.data?.map(({ name, value }) => `${name}:${value}`) ?? []),
                    ...(filter.labels ?? []),
                  ]),
                ]}
                searchable
                clearable
                maxValues={16}
                nothingFoundMessage="No such label"
                value={[...(filter.labels ?? [])]}
                onChange={(labels) => narrow({ labels })}
              />
            )}
            {(outdated > 0 || filter.outdated) && (
              <Switch
                label={`To be indexed again (${integer(outdated)})`}
                checked={filter.outdated ?? false}
                onChange={(event) => narrow({ outdated: event.currentTarget.checked })}
              />
            )}
            {filter.outdated && outdated > 0 && (
              <Button
                variant="light"
                leftSection={<RotateCw size={15} aria-hidden="true" />}
                loading={again.isPending}
                onClick={() => again.reindex(here)}
              >
                Index {outdated === 1 ? "it" : "them"} again
              </Button>
            )}
            {items.length > 1 && (
              <Select
                aria-label="Order"
                w={150}
                allowDeselect={false}
                data={ORDERS}
                value={filter.order ?? "-created"}
                onChange={(order) => narrow({ order: order === "-created" ? undefined : (order as ShapeOrder) })}
              />
            )}
            {items.length > 0 && (
              <Button
                variant="default"
                leftSection={chosen ? <X size={15} aria-hidden="true" /> : <ListChecks size={15} aria-hidden="true" />}
                aria-pressed={chosen !== null}
                onClick={() => setChosen(chosen ? null : new Set())}
              >
                {chosen ? "Done" : "Choose"}
              </Button>
            )}
          </div>
          {chosen && (
            <ChosenBar chosen={chosen} all={items.map(({ id }) => id)} collections={all} onChosen={setChosen} />
          )}
          {shapes.isPending ? (
            <Waiting label="Loading the shapes…" />
          ) : shapes.isError && !shapes.data ? (
            <Failure error={shapes.error} onRetry={() => void shapes.refetch()} />
          ) : items.length === 0 ? (
            <NoShapes filtered={filtered} collection={filter.collection} onAdd={() => setPicked([])} />
          ) : (
            <Wall shapes={items} more={hasNextPage} onMore={more} chosen={chosen} onChoose={choose} />
          )}
          {isFetchingNextPage && (
            <Text size="sm" c="dimmed" ta="center" py="md" role="status">
              Loading more…
            </Text>
          )}
        </div>
      </div>
      <AddShapes picked={picked} collection={filter.collection} onClose={() => setPicked(null)} />
    </Page>
  );
}

interface ChosenBarProps {
  chosen: ReadonlySet<string>;
  all: readonly string[];
  collections: readonly Collection[];
  onChosen: (chosen: ReadonlySet<string>) => void;
}

/** What to do with the shapes that are ticked. */
function ChosenBar({ chosen, all, collections, onChosen }: ChosenBarProps) {
  const change = useChangeShapes();
  const many = chosen.size === 1 ? "1 shape" : `${integer(chosen.size)} shapes`;
  const run = (collection: string | null) =>
    change.mutate(
      { ids: [...chosen], collection },
      {
        onSuccess: () =>
          say(collection === null ? `${many} deleted` : `${many} moved`, collection ?? "The meshes stay."),
        onError: (error) => sayFailure(collection === null ? "Not all were deleted" : "Not all were moved", error),
        onSettled: () => onChosen(new Set()),
      },
    );
  return (
    <Group className={classes.chosenBar ?? ""} gap="sm" role="group" aria-label="What to do with the chosen shapes">
      <Text size="sm" fw={600} aria-live="polite">
        {many} chosen
      </Text>
      <Button size="compact-sm" variant="subtle" color="gray" onClick={() => onChosen(new Set(all))}>
        All {integer(all.length)} shown
      </Button>
      <Select
        size="xs"
        w={190}
        aria-label="Move to"
        placeholder="Move to…"
        data={collections.map(({ name }) => name)}
        searchable
        disabled={chosen.size === 0 || change.isPending}
        value={null}
        onChange={(name) => name && run(name)}
      />
      <Sure size="xs" sure={`Delete ${many} for good`} loading={change.isPending} onSure={() => run(null)}>
        {(ask) => (
          <Button
            size="xs"
            variant="default"
            disabled={chosen.size === 0 || change.isPending}
            loading={change.isPending}
            onClick={ask}
          >
            Delete
          </Button>
        )}
      </Sure>
    </Group>
  );
}

function NoShapes({
  filtered,
  collection,
  onAdd,
}: {
  filtered: boolean;
  collection: string | undefined;
  onAdd: () => void;
}) {
  if (filtered) {
    return (
      <Empty icon={<Search size={32} />} title="No shape is like that">
        <LinkButton to="/shapes" search={collection ? { collection } : {}} variant="default" mt="sm">
          Without filters
        </LinkButton>
      </Empty>
    );
  }
  return (
    <Empty icon={<Shapes size={32} />} title={collection ? `“${collection}” is empty` : "No shapes yet"}>
      <Stack align="center" gap="xs">
        <Text c="dimmed" size="sm">
          Drop meshes anywhere on this page. Each is repaired where it has to be, taken apart into its parts, and can
          then be found by anything that resembles it.
        </Text>
        <Button mt="sm" leftSection={<Plus size={16} aria-hidden="true" />} onClick={onAdd}>
          Add shapes
        </Button>
      </Stack>
    </Empty>
  );
}
