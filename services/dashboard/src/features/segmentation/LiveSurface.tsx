import { Center, Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { useEffect } from "react";
import { apiFetch } from "@/api/client";
import type { Job } from "@/api/types";
import { LABELS } from "@/viewers/labels";
import { type Frame, readEvolution } from "@/viewers/surface/evolution";
import { SurfaceCanvas } from "@/viewers/surface/SurfaceCanvas";
import { useDrawing } from "@/viewers/useDrawing";
import { ViewerFrame, type ViewerStatus } from "@/viewers/ViewerFrame";
import frame from "@/viewers/viewers.module.css";
import { hasWebGL } from "@/viewers/webgl";
import classes from "./segmentation.module.css";

const NOTHING_YET: ViewerStatus = { is: "ready" };

/** The surfaces of a segmentation that runs, as they are just now. */
export default function LiveSurface({ job }: { job: Job }) {
  const preview = useQuery({
    queryKey: ["jobs", "preview", job.id, job.attempt, job.preview],
    enabled: job.preview > 0,
    staleTime: Number.POSITIVE_INFINITY,
    gcTime: 0,
    retry: false,
    queryFn: async ({ signal }): Promise<Frame[] | null> => {
      const response = await apiFetch(`/v1/jobs/${job.id}/preview`, { signal });
      return response.status === 204 ? null : readEvolution(await response.arrayBuffer());
    },
    // Until the next one is here, the last one stays; also where the work has just ended.
    placeholderData: (before) => before,
  });
  const frames = preview.data ?? null;
  const there = frames !== null;

  const what = "Drawing…";
  const { parent, status, drawing, retry } = useDrawing(there || null, what, ({ element, onLost, keep }) => {
    const canvas = keep(new SurfaceCanvas(element, onLost));
    canvas.stage.tell("The surface as it grows, in 3D.", "live");
    return canvas;
  });
  useEffect(() => {
    if (!frames || !drawing) return;
    drawing.grow(frames, LABELS[0].color);
    drawing.follow();
  }, [frames, drawing]);

  if (!hasWebGL()) return null;
  return (
    <div className={classes.live}>
      <ViewerFrame label="As it grows" status={there ? status : NOTHING_YET} tools={null} onRetry={retry}>
        <div ref={parent} className={frame.stage} />
        {!there && (
          <Center h="100%" p="lg">
            <Text size="sm" c="gray.5" ta="center">
              The surface will be seen here as soon as it grows.
            </Text>
          </Center>
        )}
      </ViewerFrame>
    </div>
  );
}
