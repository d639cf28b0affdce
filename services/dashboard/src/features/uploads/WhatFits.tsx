import { Film, ScanSearch } from "lucide-react";
import type { Asset } from "@/api/types";
import { LinkButton } from "@/app/links";
import { Look } from "@/features/preview/Look";

/** What can be done at once with a file that was uploaded; volumes are segmented by the form beside them. */
export function WhatFits({ asset }: { asset: Asset }) {
  return (
    <>
      {asset.kind === "mesh" && (
        <LinkButton
          to="/shapes/search"
          search={{ asset: asset.id }}
          size="compact-sm"
          variant="default"
          leftSection={<ScanSearch size={14} aria-hidden="true" />}
        >
          Find similar
        </LinkButton>
      )}
      {asset.kind === "sequence" && (
        <LinkButton
          to="/motion"
          search={{ sequence: asset.id }}
          size="compact-sm"
          variant="default"
          leftSection={<Film size={14} aria-hidden="true" />}
        >
          Compress
        </LinkButton>
      )}
      <Look asset={asset} />
    </>
  );
}
