import { Group, Stack, Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { Brush as BrushIcon, ExternalLink } from "lucide-react";
import { lazy, Suspense, useMemo, useState } from "react";
import type { SearchHit } from "@/api/types";
import { LinkButton } from "@/app/links";
import { beside } from "@/viewers/shape/align";
import { matchedColors, PAINT, type Rgb, UNMATCHED } from "@/viewers/shape/colors";
import { modelQuery } from "@/viewers/shape/model";
import { ViewLink } from "@/viewers/shape/ViewLink";
import { Tool } from "@/viewers/Tool";
import { NoWebGL, ViewerComing } from "@/viewers/ViewerFrame";
import { hasWebGL } from "@/viewers/webgl";
import { colorLaid, colorLevel, colorParts, facesOf } from "./coloring";
import { best } from "./HitList";
import { PaintPanel } from "./PaintPanel";
import type { SearchAddress } from "./searching";
import { ShapePicture } from "./ShapePicture";
import classes from "./shape.module.css";
import { finest, usePainting } from "./usePainting";

const ShapeViewer = lazy(async () => ({ default: (await import("@/viewers/shape/ShapeViewer")).ShapeViewer }));

interface PairViewProps {
  name: string;
  /** Where the query's mesh and parts are; null where it cannot be shown. */
  files: { mesh: string; components: string; version: string } | null;
  hit: SearchHit | null;
  /** Of the query's finest level, that were searched with; empty for all. */
  parts: readonly number[];
  address: SearchAddress;
}

const NO_FILES = { mesh: "", components: "", version: "" };

/** The query and one of the found shapes side by side, lying alike, turned together, what was matched in the same colors. */
export function PairView({ name, files, hit, parts, address }: PairViewProps) {
  const [link] = useState(() => new ViewLink());
  const { mesh, components, version } = files ?? NO_FILES;
  const query = useQuery({ ...modelQuery(mesh, components, version), enabled: files !== null });
  const shape = hit?.shape;
  const other = useQuery({
    ...modelQuery(shape?.mesh_url ?? "", shape?.components_url ?? "", shape?.indexed_at),
    enabled: shape !== undefined,
  });
  // How the found one lies depends on the query, and is waited for.
  const waits = files !== null && query.isPending;
  const lies = useMemo(
    () => (other.data && query.data && hit ? beside(other.data, query.data, hit.level, hit.matches) : other.data),
    [other.data, query.data, hit],
  );
  const found = { ...other, data: waits ? undefined : lies };
  const [paints, setPaints] = useState(false);
  const painting = usePainting(query.data, parts);
  const matched = useMemo(() => (hit ? matchedColors(hit.matches) : null), [hit]);
  const region = parts.join(" ");
  const queryColors = useMemo(() => {
    if (!query.data) return null;
    if (matched && hit) return colorParts(query.data, hit.level, matched.query, UNMATCHED);
    if (region === "") return colorLevel(query.data, null);
    const painted = new Map<number, Rgb>(region.split(" ").map((part) => [Number(part), PAINT]));
    return colorParts(query.data, finest(query.data), painted, UNMATCHED);
  }, [query.data, matched, hit, region]);
  const laidColors = useMemo(
    () => (found.data && query.data && hit ? colorLaid(found.data, hit.cells, query.data, hit.level, UNMATCHED) : null),
    [found.data, query.data, hit],
  );
  const foundColors = useMemo(
    () =>
      laidColors ?? (found.data && matched && hit ? colorParts(found.data, hit.level, matched.found, UNMATCHED) : null),
    [laidColors, found.data, matched, hit],
  );
  // A region is looked at from where it shows; whole shapes from where their pictures do.
  const [queryFocus, foundFocus] = useMemo(() => {
    if (region === "" || !hit || !matched || !query.data || !found.data) return [null, null];
    return [
      facesOf(query.data, hit.level, new Set(matched.query.keys())),
      facesOf(found.data, hit.level, new Set(matched.found.keys())),
    ];
  }, [region, hit, matched, query.data, found.data]);
  const counts = `${matched?.query.size ?? 0} of the example’s, ${matched?.found.size ?? 0} of the found shape’s`;
  return (
    <Stack gap="md" style={{ minWidth: 0 }}>
      {hasWebGL() ? (
        <div className={classes.pair}>
          <Suspense
            fallback={
              <>
                {files && <ViewerComing label={name} />}
                {hit && <ViewerComing label={hit.shape.name} />}
              </>
            }
          >
            {files && (
              <ShapeViewer
                label={name}
                testId="query"
                model={query}
                colors={paints ? painting.colors : queryColors}
                link={link}
                focus={queryFocus}
                onPaint={paints ? painting.onPaint : null}
                tools={
                  <Tool
                    label="Paint a region and search with it"
                    icon={BrushIcon}
                    on={paints}
                    onClick={() => setPaints(!paints)}
                  />
                }
              />
            )}
            {hit && (
              <ShapeViewer
                key={hit.shape_id}
                label={hit.shape.name || "Without a name"}
                testId="found"
                model={found}
                colors={foundColors}
                link={link}
                focus={foundFocus}
                tools={
                  <LinkButton
                    to="/shapes/$shapeId"
                    params={{ shapeId: hit.shape_id }}
                    size="compact-sm"
                    h={30}
                    variant="default"
                    leftSection={<ExternalLink size={13} aria-hidden="true" />}
                  >
                    Open
                  </LinkButton>
                }
              />
            )}
          </Suspense>
        </div>
      ) : (
        <NoWebGL>{hit && <ShapePicture shape={hit.shape} size={220} />}</NoWebGL>
      )}
      {paints && query.data ? (
        <PaintPanel model={query.data} painting={painting} search={{ ...address }} onClose={() => setPaints(false)} />
      ) : (
        hit && (
          <Text size="sm" c="dimmed" data-testid="pair">
            {hit.shape.name || "This one"}: score {hit.score.toFixed(2)}, best on {best(hit)}.{" "}
            {hasWebGL()
              ? laidColors
                ? `Each part of the example has its color where it lies on the found shape (matched: ${counts}); nothing lies on gray. Both turn together.`
                : `The same color means that the parts were matched (${counts}); gray was matched with nothing. Both turn together.`
              : `Parts that were matched: ${counts}.`}
          </Text>
        )
      )}
      {hit && !paints && (
        <Group gap="xs">
          <LinkButton to="/shapes/search" search={{ shape: hit.shape_id }} variant="subtle" size="compact-sm">
            Go on with shapes like {hit.shape.name || "this one"}
          </LinkButton>
          {!hasWebGL() && (
            <LinkButton to="/shapes/$shapeId" params={{ shapeId: hit.shape_id }} variant="subtle" size="compact-sm">
              Open it
            </LinkButton>
          )}
        </Group>
      )}
    </Stack>
  );
}
