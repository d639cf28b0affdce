import { ActionIcon, Button, Menu, Text, Tooltip } from "@mantine/core";
import { FileOutput } from "lucide-react";
import { useState } from "react";
import { save } from "@/app/save";
import { sayFailure } from "@/app/say";
import { MESH_FORMATS, meshFile, type MeshEnding } from "@/format/meshFiles";
import type { SurfaceMesh } from "./surface/readSurface";

interface SaveMeshProps {
  /** What is saved, without an ending. */
  name: string;
  mesh: () => Promise<SurfaceMesh>;
  /** What the button does, where it is one of a viewer's tools. */
  tool?: string;
}

/** Saves a mesh in other formats than the one it is kept in; they are made in the browser when they are asked for. */
export function SaveMesh({ name, mesh, tool }: SaveMeshProps) {
  const [busy, setBusy] = useState(false);
  const convert = async (ending: MeshEnding) => {
    setBusy(true);
    try {
      save(meshFile(await mesh(), ending), `${name}.${ending}`);
    } catch (error) {
      sayFailure(`${name}.${ending} could not be made`, error);
    } finally {
      setBusy(false);
    }
  };
  return (
    <Menu position="bottom-end" shadow="md">
      <Menu.Target>
        {tool ? (
          <Tooltip label={tool} openDelay={400}>
            <ActionIcon variant="default" size={30} loading={busy} aria-label={tool}>
              <FileOutput size={16} aria-hidden="true" />
            </ActionIcon>
          </Tooltip>
        ) : (
          <Button variant="default" size="compact-xs" loading={busy} aria-label={`STL, OBJ of ${name}`}>
            STL, OBJ
          </Button>
        )}
      </Menu.Target>
      <Menu.Dropdown>
        {MESH_FORMATS.map(({ ending, label, says }) => (
          <Menu.Item key={ending} onClick={() => void convert(ending)}>
            {label}{" "}
            <Text span size="xs" c="dimmed">
              {says}
            </Text>
          </Menu.Item>
        ))}
      </Menu.Dropdown>
    </Menu>
  );
}
