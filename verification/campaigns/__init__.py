"""Campaigns: many flights with and without faults through sheets, and the statistics of what came out.

A campaign is a YAML file (`reader`), its content a `plan`; `cases` numbers its runs, `work` flies a chunk of them,
`pool` and `cluster` do that in processes, `store` keeps the results, `metrics` and `tables` say what they amount to.
"""
