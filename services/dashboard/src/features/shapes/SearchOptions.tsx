import { MultiSelect, SegmentedControl, Select, Switch, Tooltip } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { collectionsQuery, labelsQuery } from "@/api/shapes";
import type { SearchAddress } from "./searching";
import classes from "./shape.module.css";

type Change = { [K in keyof SearchAddress]: SearchAddress[K] | undefined };

/** What is compared, and where is searched. */
export function SearchOptions({ address, onChange }: { address: SearchAddress; onChange: (change: Change) => void }) {
  const collections = useQuery(collectionsQuery);
  const labels = useQuery(labelsQuery(address.collection));
  const region = address.parts !== undefined;
  const known = labels.data?.map(({ name, value }) => `${name}:${value}`) ?? [];
  return (
    <div className={classes.options} role="group" aria-label="How to search">
      {region ? (
        <Tooltip label="Search with the whole shape again">
          <SegmentedControl
            size="sm"
            aria-label="What is compared"
            data={[
              { value: "whole", label: "Whole shape" },
              { value: "region", label: "Painted region" },
            ]}
            value="region"
            onChange={(value) => value === "whole" && onChange({ parts: undefined })}
          />
        </Tooltip>
      ) : (
        <SegmentedControl
          size="sm"
          aria-label="What is compared"
          data={[
            { value: "global", label: "Whole shape" },
            { value: "partial", label: "As a part of others" },
          ]}
          value={address.mode ?? "global"}
          onChange={(value) => onChange({ mode: value === "partial" ? "partial" : undefined })}
        />
      )}
      <Select
        size="sm"
        w={180}
        aria-label="Collection"
        placeholder="All collections"
        clearable
        searchable
        data={collections.data?.map(({ name }) => name) ?? []}
        value={address.collection ?? null}
        onChange={(collection) => onChange({ collection: collection ?? undefined })}
      />
      {(known.length > 0 || address.labels) && (
        <MultiSelect
          size="sm"
          miw={180}
          aria-label="Labels"
          placeholder={address.labels ? "" : "All labels"}
          searchable
          clearable
          maxValues={16}
          data={[...new Set([...known, ...(address.labels ?? [])])]}
          value={address.labels ?? []}
          onChange={(chosen) => onChange({ labels: chosen.length > 0 ? chosen : undefined })}
        />
      )}
      {!region && address.mode !== "partial" && (
        <Switch
          label="Order by their likeness to each other, too"
          checked={address.rerank ?? false}
          onChange={(event) => onChange({ rerank: event.currentTarget.checked ? true : undefined })}
        />
      )}
    </div>
  );
}
