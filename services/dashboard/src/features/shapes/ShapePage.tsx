import { Button, Group, Stack } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { getRouteApi, useNavigate } from "@tanstack/react-router";
import { Brush as BrushIcon, ScanSearch, Trash2 } from "lucide-react";
import { lazy, Suspense, useMemo, useState } from "react";
import { Warnings } from "@/app/Warnings";
import { requestOf } from "@/api/search";
import { shapeQuery, useDeleteShape } from "@/api/shapes";
import type { ShapeDetail } from "@/api/types";
import { LinkAnchor, LinkButton } from "@/app/links";
import { One } from "@/app/One";
import { Page } from "@/app/Page";
import { say, sayFailure } from "@/app/say";
import { Sure } from "@/app/Sure";
import { useNow } from "@/app/useNow";
import { AsCode } from "@/features/snippets/AsCode";
import { searchSnippets } from "@/features/snippets/snippets";
import { ago, moment } from "@/format/format";
import { graphOf } from "@/viewers/shape/graph";
import { modelQuery, type ShapeModel } from "@/viewers/shape/model";
import { NoWebGL, ViewerComing } from "@/viewers/ViewerFrame";
import { hasWebGL } from "@/viewers/webgl";
import { colorLevel } from "./coloring";
import { PaintPanel } from "./PaintPanel";
import { ReindexNotice } from "./ReindexNotice";
import { ShapeAbout } from "./ShapeAbout";
import { ShapeFacts } from "./ShapeFacts";
import { ShapeFiles } from "./ShapeFiles";
import { ShapePicture } from "./ShapePicture";
import classes from "./shape.module.css";
import { usePainting } from "./usePainting";
import { ViewTools } from "./ViewTools";

const ShapeViewer = lazy(async () => ({ default: (await import("@/viewers/shape/ShapeViewer")).ShapeViewer }));

const route = getRouteApi("/shapes/$shapeId");

export function ShapePage() {
  const { shapeId } = route.useParams();
  const shape = useQuery(shapeQuery(shapeId));
  return (
    <One
      query={shape}
      what="shape"
      missing="It was deleted, its address may be mistyped, or it belongs to another key."
      back={
        <LinkButton to="/shapes" variant="default" mt="sm">
          To the shapes
        </LinkButton>
      }
    >
      {(found) => <LoadedShape key={shapeId} shape={found} />}
    </One>
  );
}

function LoadedShape({ shape }: { shape: ShapeDetail }) {
  const now = useNow(30_000);
  const name = shape.name || "Without a name";
  return (
    <Page
      title={name}
      trail={[
        <LinkAnchor key="shapes" to="/shapes" size="sm">
          Shapes
        </LinkAnchor>,
        <LinkAnchor key="collection" to="/shapes" search={{ collection: shape.collection }} size="sm">
          {shape.collection}
        </LinkAnchor>,
      ]}
      lead={<span title={moment(shape.indexed_at)}>indexed {ago(shape.indexed_at, now)}</span>}
      actions={
        <Group gap="sm">
          <DeleteShape shape={shape} />
          <LinkButton
            to="/shapes/search"
            search={{ shape: shape.id }}
            leftSection={<ScanSearch size={16} aria-hidden="true" />}
          >
            Find similar
          </LinkButton>
        </Group>
      }
    >
      <Stack gap="md">
        {shape.outdated && <ReindexNotice shape={shape} />}
        <Warnings of={shape.warnings} />
        <div className={classes.columns}>
          <Stack gap="md" style={{ minWidth: 0 }}>
            {hasWebGL() ? (
              <View shape={shape} />
            ) : (
              <NoWebGL>
                <ShapePicture shape={shape} size={220} />
              </NoWebGL>
            )}
            <ShapeFacts shape={shape} />
          </Stack>
          <Stack gap="md">
            <ShapeAbout shape={shape} />
            <ShapeFiles shape={shape} />
            <AsCode
              title="Find similar, as code"
              of={(target) => searchSnippets(requestOf({ shape: shape.id }), target)}
            />
          </Stack>
        </div>
      </Stack>
    </Page>
  );
}

function View({ shape }: { shape: ShapeDetail }) {
  const model = useQuery(modelQuery(shape.mesh_url, shape.components_url, shape.indexed_at));
  const [asked, setLevel] = useState<number | null | "finest">("finest");
  const [withGraph, setGraph] = useState(false);
  const [paints, setPaints] = useState(false);
  const painting = usePainting(model.data);
  const levels = model.data?.levels.filter((level) => level > 0) ?? [];
  const level = asked === "finest" ? (levels.at(-1) ?? null) : asked;
  const colors = useLevelColors(model.data, level);
  const graph = useGraph(model.data, shape.levels, withGraph ? level : null);
  return (
    <>
      <div className={classes.view}>
        <Suspense fallback={<ViewerComing label={shape.name || "Shape"} />}>
          <ShapeViewer
            label={shape.name || "Shape"}
            model={model}
            colors={paints ? painting.colors : colors}
            graph={paints ? null : graph}
            onPaint={paints ? painting.onPaint : null}
            tools={
              paints ? null : (
                <ViewTools
                  levels={shape.levels.filter((one) => levels.includes(one.level))}
                  level={level}
                  onLevel={setLevel}
                  graph={withGraph}
                  onGraph={setGraph}
                >
                  <Button
                    size="compact-sm"
                    h={30}
                    variant="default"
                    leftSection={<BrushIcon size={14} aria-hidden="true" />}
                    onClick={() => setPaints(true)}
                  >
                    Paint a region
                  </Button>
                </ViewTools>
              )
            }
          />
        </Suspense>
      </div>
      {paints && model.data && (
        <PaintPanel
          model={model.data}
          painting={painting}
          search={{ shape: shape.id }}
          onClose={() => setPaints(false)}
        />
      )}
    </>
  );
}

function useLevelColors(model: ShapeModel | undefined, level: number | null) {
  return useMemo(() => (model ? colorLevel(model, level) : null), [model, level]);
}

function useGraph(model: ShapeModel | undefined, levels: ShapeDetail["levels"], level: number | null) {
  return useMemo(() => (model && level !== null ? graphOf(model, levels, level) : null), [model, levels, level]);
}

function DeleteShape({ shape }: { shape: ShapeDetail }) {
  const navigate = useNavigate();
  const remove = useDeleteShape();
  const run = () =>
    remove.mutate(shape.id, {
      onSuccess: () => {
        say("Deleted", `${shape.name || "The shape"} is found no more. Its mesh stays.`);
        void navigate({ to: "/shapes", search: { collection: shape.collection } });
      },
      onError: (error) => sayFailure("Not deleted", error),
    });
  return (
    <Sure sure="Delete for good" loading={remove.isPending} onSure={run}>
      {(ask) => (
        <Button variant="default" leftSection={<Trash2 size={15} aria-hidden="true" />} onClick={ask}>
          Delete
        </Button>
      )}
    </Sure>
  );
}
