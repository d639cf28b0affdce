import { Paper, Text, Title } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { Download } from "lucide-react";
import { assetQuery } from "@/api/queries";
import type { Shape } from "@/api/types";
import { SaveLink } from "@/features/jobs/SaveLink";
import { bytes } from "@/format/format";
import { readMeshAt } from "@/viewers/readMeshAt";
import { SaveMesh } from "@/viewers/SaveMesh";
import classes from "./shape.module.css";

/** What can be downloaded of a shape. */
export function ShapeFiles({ shape }: { shape: Shape }) {
  const asset = useQuery({ ...assetQuery(shape.asset_id), retry: false });
  const stem = (shape.name || "shape").replaceAll(/[^\w.-]+/g, "-");
  const files: [string, string, string][] = [
    [shape.mesh_url, `${stem}.glb`, "The repaired mesh, for viewers"],
    [shape.arg_url, `${stem}.arg`, "The graph of its parts"],
    [shape.components_url, `${stem}-parts.json`, "The part of each vertex of the .glb, by level"],
    [shape.preview_url, `${stem}.png`, "The picture"],
  ];
  return (
    <Paper p="md" component="section" aria-labelledby="files">
      <Title order={2} id="files" mb="xs">
        Downloads
      </Title>
      <ul className={classes.files}>
        <li>
          <Download size={15} aria-hidden="true" />
          <span>
            {asset.data ? (
              <SaveLink url={asset.data.content_url} name={asset.data.filename}>
                {asset.data.filename}
              </SaveLink>
            ) : (
              <Text span size="sm" c="dimmed">
                {asset.isError ? "The uploaded mesh was deleted" : "…"}
              </Text>
            )}
            <Text size="xs" c="dimmed">
              As uploaded{asset.data ? `, ${bytes(asset.data.size)}` : ""}
            </Text>
          </span>
        </li>
        {files.map(([url, name, says]) => (
          <li key={url}>
            <Download size={15} aria-hidden="true" />
            <span>
              <SaveLink url={url} name={name}>
                {name}
              </SaveLink>
              {url === shape.mesh_url && " "}
              {url === shape.mesh_url && <SaveMesh name={stem} mesh={() => readMeshAt(url)} />}
              <Text size="xs" c="dimmed">
                {says}
              </Text>
            </span>
          </li>
        ))}
      </ul>
    </Paper>
  );
}
