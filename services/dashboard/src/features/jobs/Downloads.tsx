import { Paper, Text, Title } from "@mantine/core";
import { Download } from "lucide-react";
import type { Artifact } from "@/api/types";
import { bytes } from "@/format/format";
import { readMeshAt } from "@/viewers/readMeshAt";
import { SaveMesh } from "@/viewers/SaveMesh";
import classes from "./jobs.module.css";
import { SaveLink } from "./SaveLink";

const TELLS: Record<string, string> = {
  "labels.nii.gz": "Labels on the grid of the volume after contrast",
  "evolution.bin": "How the surfaces grew, coarse, to be watched",
  "surfaces/microhemorrhages.ply": "The surface of all bleedings, RAS mm",
  "surface.ply": "All surfaces of the objects, RAS mm",
  "scene.glb": "All structures as one scene",
  "report.json": "All measurements, with parameters and versions",
  "motion.smc": "The motion file",
  "clusters.ply": "The first frame, colored by cluster",
  "clusters.png": "A picture of the clusters",
  "rate.svg": "Rate over distortion, as a plot",
  "residuals.bin.gz": "What the encoding changed, vertex by vertex",
};

/** The files that a job has made. */
export function Downloads({ artifacts }: { artifacts: readonly Artifact[] }) {
  if (artifacts.length === 0) return null;
  return (
    <Paper p="md" component="section" aria-labelledby="downloads">
      <Title order={2} id="downloads" mb="xs">
        Downloads
      </Title>
      <ul className={classes.downloads}>
        {artifacts.map((artifact) => (
          <li key={artifact.name}>
            <Download size={15} aria-hidden="true" />
            <SaveLink url={artifact.url} name={artifact.name.replaceAll("/", "-")}>
              {artifact.name}
            </SaveLink>
            <Text size="sm" c="dimmed">
              {tells(artifact.name)}
            </Text>
            {/^surface.*\.ply$/.test(artifact.name) ? (
              <SaveMesh
                name={artifact.name.replaceAll("/", "-").replace(/\.ply$/, "")}
                mesh={() => readMeshAt(artifact.url)}
              />
            ) : (
              <span />
            )}
            <Text size="sm" c="dimmed">
              {bytes(artifact.size)}
            </Text>
          </li>
        ))}
      </ul>
    </Paper>
  );
}

function tells(name: string): string {
  const surface = /^surfaces\/(\d+)\.ply$/.exec(name);
  const vessel = /^surfaces\/vessel-(\d+)\.ply$/.exec(name);
  if (surface) return `The surface of object ${surface[1]}, RAS mm`;
  if (vessel) return `The surface of vessel ${vessel[1]}, RAS mm`;
  return TELLS[name] ?? "";
}
