import { ActionIcon, Modal, Tooltip } from "@mantine/core";
import { Eye } from "lucide-react";
import { lazy, Suspense, useState } from "react";
import type { Asset } from "@/api/types";
import { createStore } from "@/app/store";
import { Failure } from "@/app/Notice";
import { NoWebGL, ViewerComing } from "@/viewers/ViewerFrame";
import { hasWebGL } from "@/viewers/webgl";
import classes from "./preview.module.css";
import { useDrawable } from "./useDrawable";

const VolumeViewer = lazy(async () => ({ default: (await import("@/viewers/volume/VolumeViewer")).VolumeViewer }));
const MotionViewer = lazy(async () => ({ default: (await import("@/viewers/motion/MotionViewer")).MotionViewer }));
const FramesViewer = lazy(() => import("./FramesViewer"));

/** A look at a file as it was uploaded. */
export function Look({ asset }: { asset: Asset }) {
  const [open, setOpen] = useState(false);
  return (
    <>
      <Tooltip label="Look at it" openDelay={400}>
        <ActionIcon
          variant="subtle"
          color="gray"
          aria-label={`Look at ${asset.filename}`}
          onClick={() => setOpen(true)}
        >
          <Eye size={16} />
        </ActionIcon>
      </Tooltip>
      <Modal opened={open} onClose={() => setOpen(false)} title={asset.filename} size="60rem" centered>
        {hasWebGL() ? (
          <div className={classes.look}>
            <Suspense fallback={<ViewerComing label={asset.filename} />}>
              <Viewer asset={asset} />
            </Suspense>
          </div>
        ) : (
          <NoWebGL />
        )}
      </Modal>
    </>
  );
}

function Viewer({ asset }: { asset: Asset }) {
  const { content_url: url, size, format } = asset;
  const [frame] = useState(() => createStore(0));
  if (asset.kind === "volume") return <Volume asset={asset} />;
  if (asset.kind === "motion") return <MotionViewer url={url} size={size} residuals={null} unit="" frame={frame} />;
  return <FramesViewer url={url} size={size} kind={asset.kind} format={format} />;
}

function Volume({ asset }: { asset: Asset }) {
  const { file, error } = useDrawable(asset);
  if (error) return <Failure error={error} />;
  if (!file) return <ViewerComing label={asset.filename} what="Reading the volume…" />;
  return <VolumeViewer image={file} labels={null} focus={null} />;
}
