import { ActionIcon, Modal, Tooltip } from "@mantine/core";
import { Eye, Film, ScanSearch } from "lucide-react";
import { lazy, Suspense, useState } from "react";
import type { Asset } from "@/api/types";
import { LinkButton } from "@/app/links";
import { Waiting } from "@/app/Notice";
import { drawableName } from "@/features/segmentation/drawable";
import { NoWebGL } from "@/viewers/ViewerFrame";
import { hasWebGL } from "@/viewers/webgl";
import classes from "./uploads.module.css";

const VolumeViewer = lazy(async () => ({
  default: (await import("@/viewers/volume/VolumeViewer")).VolumeViewer,
}));

/** What can be done at once with a file that was uploaded; volumes are segmented by the form beside them. */
export function WhatFits({ asset }: { asset: Asset }) {
  if (asset.kind === "volume") return <Look volume={asset} />;
  if (asset.kind === "mesh") {
    return (
      <LinkButton
        to="/shapes/search"
        search={{ asset: asset.id }}
        size="compact-sm"
        variant="default"
        leftSection={<ScanSearch size={14} aria-hidden="true" />}
      >
        Find similar
      </LinkButton>
    );
  }
  if (asset.kind === "sequence") {
    return (
      <LinkButton to="/motion" size="compact-sm" variant="default" leftSection={<Film size={14} aria-hidden="true" />}>
        Compress
      </LinkButton>
    );
  }
  return null;
}

/** A look at a volume as it was uploaded; DICOM series cannot be drawn before they are read. */
function Look({ volume }: { volume: Asset }) {
  const [open, setOpen] = useState(false);
  const name = drawableName(volume);
  if (!name) return null;
  const close = () => setOpen(false);
  return (
    <>
      <Tooltip label="Look at it" openDelay={400}>
        <ActionIcon
          variant="subtle"
          color="gray"
          aria-label={`Look at ${volume.filename}`}
          onClick={() => setOpen(true)}
        >
          <Eye size={16} />
        </ActionIcon>
      </Tooltip>
      <Modal opened={open} onClose={close} title={volume.filename} size="60rem" centered>
        {hasWebGL() ? (
          <div className={classes.look}>
            <Suspense fallback={<Waiting label="Loading the viewer…" />}>
              <VolumeViewer image={{ url: volume.content_url, name, size: volume.size }} labels={null} focus={null} />
            </Suspense>
          </div>
        ) : (
          <NoWebGL />
        )}
      </Modal>
    </>
  );
}
