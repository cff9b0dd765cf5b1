<?xml version="1.0" encoding="UTF-8"?>
<physicalModel name="strip" dimension="2" nrOfAtoms="6" nrOfExclusiveComponents="1" nrOfInformativeComponents="4" nrOfCells="2">
<atoms>
<structuralComponent phymul="unnumbered">
<nrOfStructures value="6"/>
<atom>
<atomProperties index="0" x="0" y="0" z="0" mass="1" stiffness="1"/>
</atom>
<atom>
<atomProperties index="1" x="10" y="0" z="0" mass="1" stiffness="1"/>
</atom>
<atom>
<atomProperties index="2" x="20" y="0" z="0" mass="1" stiffness="1"/>
</atom>
<atom>
<atomProperties index="3" x="0" y="10" z="0" mass="1" stiffness="1"/>
</atom>
<atom>
<atomProperties index="4" x="10" y="10" z="0" mass="1" stiffness="1"/>
</atom>
<atom>
<atomProperties index="5" x="20" y="10" z="0" mass="1" stiffness="1"/>
</atom>
</structuralComponent>
</atoms>
<exclusiveComponents>
<multiComponent name="Exclusive Components">
<structuralComponent name="Elements">
<nrOfStructures value="2"/>
<cell>
<cellProperties type="QUAD"/>
<nrOfStructures value="4"/>
<atomRef index="0"/>
<atomRef index="1"/>
<atomRef index="4"/>
<atomRef index="3"/>
</cell>
<cell>
<cellProperties type="QUAD"/>
<nrOfStructures value="4"/>
<atomRef index="1"/>
<atomRef index="2"/>
<atomRef index="5"/>
<atomRef index="4"/>
</cell>
</structuralComponent>
</multiComponent>
</exclusiveComponents>
<informativeComponents>
<multiComponent name="Informative Components">
<structuralComponent name="x0">
<nrOfStructures value="2"/>
<atomRef index="0"/>
<atomRef index="3"/>
</structuralComponent>
<structuralComponent name="x1">
<nrOfStructures value="2"/>
<atomRef index="2"/>
<atomRef index="5"/>
</structuralComponent>
<structuralComponent name="y0">
<nrOfStructures value="3"/>
<atomRef index="0"/>
<atomRef index="1"/>
<atomRef index="2"/>
</structuralComponent>
<structuralComponent name="y1">
<nrOfStructures value="3"/>
<atomRef index="3"/>
<atomRef index="4"/>
<atomRef index="5"/>
</structuralComponent>
</multiComponent>
</informativeComponents>
</physicalModel>
