import { Button, Paper, Stack, Text, Title } from "@mantine/core";
import { useMutation } from "@tanstack/react-query";
import { useNavigate } from "@tanstack/react-router";
import { ScanSearch } from "lucide-react";
import { useState } from "react";
import { uploadAsset } from "@/api/assets";
import { apiFetch } from "@/api/client";
import { sayFailure } from "@/app/say";

export interface SurfaceToFind {
  title: string;
  /** What it is called as an example. */
  filename: string;
  url: string;
}

const SHOWN = 3;

/** What in the bank is similar to a surface that a job has found: one click sends it off as an example. */
export function SimilarSurfaces({ surfaces }: { surfaces: readonly SurfaceToFind[] }) {
  const navigate = useNavigate();
  const [all, setAll] = useState(false);
  const find = useMutation({
    mutationFn: async ({ url, filename }: SurfaceToFind) => uploadAsset(await (await apiFetch(url)).blob(), filename),
    onSuccess: (asset) => void navigate({ to: "/shapes/search", search: { asset: asset.id } }),
    onError: (error) => sayFailure("The surface could not be searched with", error),
  });
  if (surfaces.length === 0) return null;
  return (
    <Paper p="md" component="section" aria-labelledby="similar">
      <Title order={3} id="similar" mb={4}>
        What is similar?
      </Title>
      <Text size="sm" c="dimmed" mb="sm">
        Shapes of the bank that resemble a surface found here.
      </Text>
      <Stack gap={6} align="flex-start">
        {(all ? surfaces : surfaces.slice(0, SHOWN)).map((surface) => (
          <Button
            key={surface.url}
            size="xs"
            variant="default"
            leftSection={<ScanSearch size={14} aria-hidden="true" />}
            loading={find.isPending && find.variables.url === surface.url}
            disabled={find.isPending}
            onClick={() => find.mutate(surface)}
          >
            Find shapes like {surface.title}
          </Button>
        ))}
        {surfaces.length > SHOWN && !all && (
          <Button size="compact-xs" variant="subtle" color="gray" onClick={() => setAll(true)}>
            {surfaces.length - SHOWN} more
          </Button>
        )}
      </Stack>
    </Paper>
  );
}
